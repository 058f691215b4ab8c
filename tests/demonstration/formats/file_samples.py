"""A motion written as JSON, C3D, BVH and `.pt` files, the way the tools write them that make such files.

Every writer takes (path, t (N,) s, x (N, 6, 3) m, options) and returns the path; NaN is a point not seen.
"""

import json
import struct
import zipfile

import numpy as np
from scipy.spatial.transform import Rotation

from drake_blfdmp.demonstration.formats.mocap.omomo_pt import COLUMNS, FIRST_JOINT_COLUMN, JOINTS, OBJECT_COLUMN
from drake_blfdmp.demonstration.formats.sensor_joints import AZURE_KINECT, KINECT_V1
from drake_blfdmp.skeleton import POINTS

SENSOR_NAMES = ("ShoulderLeft", "ElbowLeft", "WristLeft", "ShoulderRight", "ElbowRight", "WristRight")


def in_order(x, order, names=SENSOR_NAMES):
    """(N, len(order), 3): the six points among a sensor's other joints, which stay near them."""
    joints = np.repeat(np.nan_to_num(x).mean(axis=1, keepdims=True), len(order), axis=1) + 0.01
    joints[:, [order.index(name) for name in names]] = x
    return joints


def listed(x):
    """Nested lists with None for NaN."""
    return np.where(np.isnan(x), None, np.round(x, 9)).tolist()


def write_skeleton_json(path, t, x, order=KINECT_V1, empty=(), **top):
    frames = listed(in_order(x, order))
    document = {"file_name": path.stem, **top, "skeletons": [[] if i in empty else f for i, f in enumerate(frames)]}
    path.write_text(json.dumps(document))
    return path


def write_keypoint_json(path, t, x, names=POINTS, scale=1000.0, indent=None, **top):
    frames = [
        {"frame_id": i, "timestamp_ms": round(float(s) * 1e3, 6), "keypoint_xyz": dict(zip(names, points, strict=True))}
        for i, (s, points) in enumerate(zip(t, listed(x * scale), strict=True))
    ]
    path.write_text(json.dumps({**top, "frames": frames} if top else frames, indent=indent))
    return path


def write_azure_json(path, t, x, confidence=None, bodies=None, indent=4):
    """`bodies`: frame index -> list of (id, shift of the whole body in m); one body, 1, by default."""
    joints = in_order(x, AZURE_KINECT)
    frames = []
    for i, s in enumerate(t):
        held = []
        for name, shift in [(1, 0.0)] if bodies is None else bodies(i):
            body = {"body_id": name, "joint_orientations": [[1.0, 0.0, 0.0, 0.0]] * len(AZURE_KINECT)}
            body["joint_positions"] = listed((joints[i] + shift) * 1000.0)
            if confidence is not None:
                levels = np.full(len(AZURE_KINECT), 2)
                levels[[AZURE_KINECT.index(name) for name in SENSOR_NAMES]] = confidence[i]
                body["confidence_levels"] = levels.tolist()
            held.append(body)
        frames.append({"bodies": held, "frame_id": i, "num_bodies": len(held), "timestamp_usec": round(s * 1e6)})
    names = [name.upper() for name in AZURE_KINECT]
    document = {
        "bone_list": [[names[2], names[1]]],
        "frames": frames,
        "joint_names": names,
        "k4abt_sdk_version": "1.1.2",
    }
    path.write_text(json.dumps(document, indent=indent))
    return path


def write_c3d(
    path, t, x, labels=("LSHO", "LELB", "LWRI", "RSHO", "RELB", "RWRI"), unit="mm", scale=1000.0, integers=False,
    analog=0, y_screen="+Z", first=1, header_rate=None, promised=None, markers_a_label_block=255,
):  # fmt: skip
    """An Intel file; `integers` stores steps of 0.1 of the unit, `analog` so many channels of two samples a frame."""
    x = np.asarray(x)
    count, rate = len(t), float(1.0 / np.median(np.diff(t))) if len(t) > 1 else 30.0
    promised = count if promised is None else promised
    point_scale = 0.1 if integers else -0.1

    def parameter(group, name, bytes_each, dimensions, data):
        rest = struct.pack("bB", bytes_each, len(dimensions)) + bytes(dimensions) + data + b"\0"
        return struct.pack("bb", len(name), group) + name.encode() + struct.pack("<h", len(rest) + 2) + rest

    def group(number, name):
        return struct.pack("bb", len(name), -number) + name.encode() + struct.pack("<h", 3) + b"\0"

    def words(group_number, name, values):
        length = max(map(len, values))
        data = b"".join(value.encode().ljust(length) for value in values)
        return parameter(group_number, name, -1, (length, len(values)), data)

    def text(group_number, name, value):
        return parameter(group_number, name, -1, (len(value),), value.encode())

    section = group(1, "POINT") + parameter(1, "USED", 2, (), struct.pack("<H", len(labels)))
    section += parameter(1, "SCALE", 4, (), struct.pack("<f", point_scale))
    section += parameter(1, "RATE", 4, (), struct.pack("<f", rate))
    section += parameter(1, "FRAMES", 4, (), struct.pack("<f", first - 1 + promised))
    section += text(1, "UNITS", unit) + text(1, "X_SCREEN", "+X") + text(1, "Y_SCREEN", y_screen)
    for start in range(0, len(labels), markers_a_label_block):
        name = "LABELS" + (str(start // markers_a_label_block + 1) if start else "")
        section += words(1, name, labels[start : start + markers_a_label_block])
    if analog:
        section += group(2, "ANALOG") + parameter(2, "USED", 2, (), struct.pack("<H", analog))
        section += parameter(2, "RATE", 4, (), struct.pack("<f", 2.0 * rate))
    section += b"\0\0"
    blocks = -(-(len(section) + 4) // 512)
    header = struct.pack(
        "<BBHHHHHfHHf", 2, 80, len(labels), 2 * analog, first, min(first - 1 + promised, 65535), 10, point_scale,
        2 + blocks, 2 * (analog > 0), rate if header_rate is None else header_rate,
    )  # fmt: skip
    kind = "<i2" if integers else "<f4"
    lost = np.isnan(x).any(axis=-1)
    values = np.zeros((count, len(labels), 4))
    values[:, :, :3] = np.where(lost[..., None], 0.0, x) * scale / (0.1 if integers else 1.0)
    values[:, :, 3] = np.where(lost, -1.0, 0.0)
    rows = np.concatenate([values.reshape(count, -1), np.full((count, 2 * analog), 7.0)], axis=1)
    rows = (np.round(rows) if integers else rows).astype(kind)
    parameters = struct.pack("BBBB", 1, 80, blocks, 84) + section
    path.write_bytes(header.ljust(512, b"\0") + parameters.ljust(512 * blocks, b"\0") + rows.tobytes())
    return path


BONES = {
    "Hips": None, "Spine": "Hips",
    "LeftShoulder": "Spine", "LeftArm": "LeftShoulder", "LeftForeArm": "LeftArm", "LeftHand": "LeftForeArm",
    "RightShoulder": "Spine", "RightArm": "RightShoulder", "RightForeArm": "RightArm", "RightHand": "RightForeArm",
}  # fmt: skip
ENDS = ("LeftArm", "LeftForeArm", "LeftHand", "RightArm", "RightForeArm", "RightHand")


def bone_positions(x):
    """(N, 3) of every bone of BONES in the world, the spine below the shoulders' midpoint."""
    middle = (x[:, 0] + x[:, 3]) / 2.0
    world = dict(zip(ENDS, np.moveaxis(x, 1, 0), strict=True))
    world |= {"Hips": middle - [0.0, 0.0, 0.5], "Spine": middle - [0.0, 0.02, 0.2]}
    return world | {
        f"{side}Shoulder": middle + np.array([0.03 * s, 0.0, 0.0]) for side, s in (("Left", -1), ("Right", 1))
    }


def write_bvh(path, t, x, scale=100.0, order="ZXY", constant=False, rename=str, frames=None, seed=3):
    """By random turns of every bone and position channels that fit to them, exact for any motion.

    `constant` writes rotation channels alone, with the first frame's lengths: for motions that keep them.
    """
    world = {bone: p * scale for bone, p in bone_positions(np.asarray(x)).items()}
    names, count = list(BONES), len(t)
    rng = np.random.default_rng(seed)
    turns, offsets, rows = {}, {}, []
    for bone, parent in BONES.items():
        step = world[bone] - world[parent] if parent else world[bone]
        offsets[bone] = np.zeros(3) if parent is None else step[0]
        turns[bone] = Rotation.from_rotvec(np.sin(np.arange(count)[:, None] / 9.0 + rng.uniform(0, 6, 3)))
        if constant:
            turns[bone] = _turn_of_children(bone, world, count)
        local = turns[parent].inv().apply(step) if parent else step
        turn = turns[parent].inv() * turns[bone] if parent else turns[bone]
        if parent is None or not constant:
            rows.append(local)
        rows.append(turn.as_euler(order, degrees=True))
    lines = ["HIERARCHY"]
    _write_bone(lines, names[0], 0, offsets, order, constant, rename)
    lines += ["MOTION", f"Frames: {count if frames is None else frames}", f"Frame Time: {np.median(np.diff(t)):.9f}"]
    lines += [" ".join(f"{v:.9f}" for v in row) for row in np.concatenate(rows, axis=1)]
    path.write_text("\n".join(lines) + "\n")
    return path


def _turn_of_children(bone, world, count):
    """Turns that carry the first frame's direction to the only child to every frame's; none for bones of many."""
    children = [child for child, parent in BONES.items() if parent == bone]
    if len(children) != 1:
        return Rotation.identity(count)
    direction = world[children[0]] - world[bone]
    direction = direction / np.linalg.norm(direction, axis=-1, keepdims=True)
    axis = np.cross(direction[0], direction)
    sine = np.linalg.norm(axis, axis=-1, keepdims=True)
    angle = np.arctan2(sine[:, 0], direction @ direction[0])
    return Rotation.from_rotvec(axis / np.maximum(sine, 1e-12) * angle[:, None])


def _write_bone(lines, bone, depth, offsets, order, constant, rename):
    pad = "\t" * depth
    lines += [f"{pad}{'ROOT' if depth == 0 else 'JOINT'} {rename(bone)}", pad + "{"]
    lines.append(pad + "\tOFFSET " + " ".join(f"{v:.9f}" for v in offsets[bone]))
    turning = [f"{axis}rotation" for axis in order]
    moving = ["Xposition", "Yposition", "Zposition"] if depth == 0 or not constant else []
    lines.append(f"{pad}\tCHANNELS {len(moving + turning)} {' '.join(moving + turning)}")
    children = [child for child, parent in BONES.items() if parent == bone]
    for child in children:
        _write_bone(lines, child, depth + 1, offsets, order, constant, rename)
    if not children:
        lines += [pad + "\tEnd Site", pad + "\t{", pad + "\t\tOFFSET 0.0 0.0 0.0", pad + "\t}"]
    lines.append(pad + "}")


def write_omomo_pt(
    path, t, x, columns=COLUMNS, storage="FloatStorage", order="<", compression=zipfile.ZIP_STORED, turns=None
):
    """`turns` (N, 4) are the object's, w x y z."""
    names = [f"{side}_{part}" for side in "LR" for part in ("Shoulder", "Elbow", "Wrist")]
    values = np.zeros((len(t), columns), f"{order}f4")
    joints = in_order(x, JOINTS, names).reshape(len(t), 3 * len(JOINTS))
    values[:, FIRST_JOINT_COLUMN : FIRST_JOINT_COLUMN + joints.shape[1]] = joints[:, : columns - FIRST_JOINT_COLUMN]
    if turns is not None:
        values[:, OBJECT_COLUMN : OBJECT_COLUMN + 4] = np.roll(turns, -1, axis=-1)
    pickle = (
        b"\x80\x02ctorch._utils\n_rebuild_tensor_v2\nq\0((X\x07\0\0\0storageq\x01ctorch\n" + storage.encode() + b"\n."
    )
    with zipfile.ZipFile(path, "w", compression) as archive:
        archive.writestr(f"{path.stem}/data.pkl", pickle)
        archive.writestr(f"{path.stem}/byteorder", "little" if order == "<" else "big")
        archive.writestr(f"{path.stem}/data/0", values.tobytes())
        archive.writestr(f"{path.stem}/version", "3\n")
    return path


SAMPLES = {
    "skeleton_json": write_skeleton_json,
    "keypoint_json": write_keypoint_json,
    "azure_json": write_azure_json,
    "c3d": write_c3d,
    "bvh": write_bvh,
    "omomo_pt": write_omomo_pt,
}
"""Format -> its writer."""
