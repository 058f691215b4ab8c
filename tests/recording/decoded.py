"""A recording by an independent reader."""

from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore


def decode(path):
    """(topic -> [(time, message)], topic -> quality of service) by rosbags, with the file's own definitions."""
    store = get_typestore(Stores.EMPTY)
    messages, qos = {}, {}
    with Reader(path) as reader:
        for connection in reader.connections:
            store.register(get_types_from_msg(connection.msgdef.data, connection.msgtype))
            qos[connection.topic] = connection.ext.offered_qos_profiles[0]
            messages[connection.topic] = []
        for connection, time, data in reader.messages():
            messages[connection.topic].append((time, store.deserialize_cdr(data, connection.msgtype)))
    return messages, qos
