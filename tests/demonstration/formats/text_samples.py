"""Valid files of every text format with one motion in them: t (N,) s, x (N, 6, 3) m in the order of POINTS, z up."""

import numpy as np

from drake_blfdmp.demonstration.formats.sensor_joints import AZURE_KINECT, KINECT_V1, KINECT_V2

KINECT = ("ShoulderLeft", "ElbowLeft", "WristLeft", "ShoulderRight", "ElbowRight", "WristRight")
SHORT = ("LShoulder", "LElbow", "LWrist", "RShoulder", "RElbow", "RWrist")
TURKISH = ("solOmuz", "solDirsek", "solBilek", "sagOmuz", "sagDirsek", "sagBilek")
MOTIVE = ("LUArm", "LFArm", "LHand", "RUArm", "RFArm", "RHand")
WRISTS_FIRST = (2, 5, 1, 4, 0, 3)  # Of POINTS: the order of `points18`.


def number(value, digits=9):
    return "" if np.isnan(value) else f"{value:.{digits}f}"


def numbers(values, scale=1.0):
    return [number(scale * value) for value in np.ravel(values)]


def sensor_joints(x, order):
    """(J, 3) all joints of a sensor, of which those of KINECT lie at the points."""
    joints = np.full((len(order), 3), 0.5)
    joints[[order.index(name) for name in KINECT]] = x
    return joints


def save(path, lines, end="\n", trailing=True):
    path.write_bytes((end.join(lines) + (end if trailing else "")).encode())
    return path


def write_wide_csv(
    path,
    t,
    x,
    names=KINECT,
    axis="{}X",
    time="time_s",
    scale=1.0,
    order=None,
    separator=",",
    end="",
    extra=(),
    states=None,
):
    """Args: axis "{}X" etc.; order of the columns; separator; end of every line; extra (name, value); states (N, 6)."""
    suffix = [axis.replace("X", a) if "X" in axis else axis.replace("x", a.lower()) for a in "XYZ"]
    header = [time] if time is not None else []
    header += [s.format(name) for name in names for s in suffix]
    header += [f"{name}_state" for name in names] if states is not None else []
    header += [name for name, _ in extra]
    lines = []
    for i in range(len(t)):
        cells = [repr(float(t[i]))] if time is not None else []
        cells += numbers(x[i], scale) + (numbers(states[i]) if states is not None else [])
        lines.append([*cells, *(value for _, value in extra)])
    order = range(len(header)) if order is None else order
    return save(path, [separator.join(row[column] for column in order) + end for row in [header, *lines]])


def write_long_csv(path, t, x, names=SHORT, header="frame,time_s,joint,x,y,z", separator=",", scale=1.0):
    """Columns by `header`: frame, time_s, joint, x, y, z, confidence, body, in any order."""
    lines = [header.replace(",", separator)]
    for i in range(len(t)):
        for name, point in zip(names, x[i], strict=True):
            cells = dict(zip("xyz", numbers(point, scale), strict=True))
            cells |= {
                "frame": str(i),
                "time_s": repr(float(t[i])),
                "joint": str(name),
                "confidence": "High",
                "body": "7",
            }
            lines.append(separator.join(cells[column] for column in header.split(",")))
    return save(path, lines)


def write_joint_rows(
    path, t, x, order=KINECT_V1, first="frame", cells=3, state="2", separator=" ", end="", frames=None
):
    """Args: first "frame", "ms", "100ns" or ""; cells a joint 3, 4 (state), 7 (quaternion) or 8; end of every line."""
    frames = np.arange(len(t)) if frames is None else frames
    more = {3: [], 4: [state], 7: ["1", "0", "0", "0"], 8: ["1", "0", "0", "0", state]}[cells]
    lines = []
    for i in range(len(t)):
        start = {"frame": [str(frames[i])], "ms": [f"{1e3 * t[i]:.3f}"], "100ns": [f"{1e7 * t[i]:.0f}"], "": []}[first]
        joints = [cell for point in sensor_joints(x[i], order) for cell in (*numbers(point), *more)]
        lines.append(separator.join([*start, *joints]) + end)
    return save(path, lines)


def write_kinect_v2_rows(path, t, x):
    return write_joint_rows(path, t, x, KINECT_V2, "100ns", 4, separator=",", end=",")


def write_azure_kinect_rows(path, t, x):
    return write_joint_rows(path, t, 1e3 * x, AZURE_KINECT, "ms", 8, separator=";")


def write_points18(path, t, x, order=WRISTS_FIRST, first=False, separator=" "):
    rows = [([f"{t[i]:.9f}"] if first else []) + numbers(x[i][list(order)]) for i in range(len(t))]
    return save(path, [separator.join(row) for row in rows])


def write_trc(path, t, x, names=TURKISH, header=True, unit="mm", scale=1000.0, times=True, labels=True, spaced=True):
    """Args: header: the three lines above the names; times: the Time column has numbers; spaced: three cells a name."""
    rate = f"{(len(t) - 1) / (t[-1] - t[0]):g}" if len(t) > 1 else "30"
    lines = []
    if header:
        lines += ["PathFileType\t4\t(X/Y/Z)\tcarry.trc"]
        lines += ["DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames"]
        lines += [f"{rate}\t{rate}\t{len(t)}\t6\t{unit}\t{rate}\t1\t{len(t)}"]
    lines += ["Frame#\tTime\t" + ("\t\t\t" if spaced else "\t").join(names) + ("\t\t" if spaced else "")]
    lines += ["\t\t" + "\t".join(f"{a}{i + 1}" for i in range(6) for a in "XYZ")] if labels else []
    lines += [""] if header else []
    for i in range(len(t)):
        lines.append("\t".join([str(i + 1), number(t[i]) if times else "", *numbers(x[i], scale)]))
    return save(path, lines)


def write_motive_csv(path, t, x, kind="Bone", names=MOTIVE, people=("Anna",), version="1.23", unit="Meters", scale=1.0):
    """Every object with its rotation before its position; the second and further people are smaller."""
    rate = f"{(len(t) - 1) / (t[-1] - t[0]):.6f}" if len(t) > 1 else "30.000000"
    objects = [f"{person}:{name}" if person else name for person in people for name in names]
    lines = [
        f"Format Version,{version},Take Name,Take 1,Capture Frame Rate,{rate},Export Frame Rate,{rate},"
        f"Capture Start Time,2020-01-01 12.00.00.000 PM,Total Exported Frames,{len(t)},Rotation Type,Quaternion,"
        f"Length Units,{unit},Coordinate Space,Global",
        "",
        ",Type," + ",".join([kind] * 7 * len(objects)),
        ",Name," + ",".join(",".join([name] * 7) for name in objects),
        ",ID," + ",".join(["1234"] * 7 * len(objects)),
        ",," + ",".join((["Rotation"] * 4 + ["Position"] * 3) * len(objects)),
        "Frame,Time (Seconds)," + ",".join(["X,Y,Z,W,X,Y,Z"] * len(objects)),
    ]
    for i in range(len(t)):
        cells = [str(i), number(t[i], 6)]
        for person in range(len(people)):
            for point in x[i] * 0.9**person:
                cells += ["0.0", "0.0", "0.0", "1.0", *numbers(point, scale)]
        lines.append(",".join(cells))
    return save(path, lines, end="\r\n")


def write_ntu_skeleton(path, t, x, people=("72057594037931101",), empty=(), end="\r\n"):
    """Args: people: their ids, the second and further smaller; empty: numbers of frames that hold nobody."""
    lines = [str(len(t))]
    for i in range(len(t)):
        present = () if i in empty else people
        lines.append(str(len(present)))
        for person, name in enumerate(present):
            lines += [f"{name} 0 1 1 1 1 0 0.0123 -0.2345 2", "25"]
            for name, point in zip(KINECT_V2, sensor_joints(x[i] * 0.9**person, KINECT_V2), strict=True):
                state = 1 if name == "WristLeft" else 2
                lines.append(" ".join(numbers(point)) + f" 277.4 191.8 1036.2 519.1 -0.21 0.03 0.97 -0.07 {state}")
    return save(path, lines, end)


SAMPLES = {
    "wide_csv": write_wide_csv,
    "long_csv": write_long_csv,
    "kinect_v1_rows": write_joint_rows,
    "kinect_v2_rows": write_kinect_v2_rows,
    "azure_kinect_rows": write_azure_kinect_rows,
    "points18": write_points18,
    "trc": write_trc,
    "motive_csv": write_motive_csv,
    "ntu_skeleton": write_ntu_skeleton,
}
"""Format name -> writer(path, t, x) -> path."""
