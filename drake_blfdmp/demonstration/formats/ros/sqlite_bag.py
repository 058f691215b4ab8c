"""The SQLite files of ROS 2 bags: tables `topics` and `messages`, since Iron also `message_definitions`."""

import sqlite3
from pathlib import Path

from drake_blfdmp.demonstration.formats.ros.ros_topics import Bag, Topic, printable
from drake_blfdmp.errors import RecordingError

SQLITE_MAGIC = b"SQLite format 3\0"


def add_sqlite(bag: Bag, path: Path, named: Path) -> None:
    """Adds the messages of an SQLite file.

    Args:
        bag: what to add to.
        path: the file.
        named: what it is called in messages.

    Raises:
        RecordingError: no bag's tables, damage, or more messages than fit.
    """
    size = path.stat().st_size
    try:
        connection = sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro", uri=True)
        try:
            # Pages of a damaged file may form circles: no sound file takes more steps than it has bytes.
            steps = iter(range(10 + size // 1000))
            connection.set_progress_handler(lambda: next(steps, None) is None, 10_000)
            _read(bag, connection, size)
        finally:
            connection.close()
    except (sqlite3.Error, ValueError, OverflowError) as error:
        raise RecordingError(
            f"{named}: is no ROS 2 bag, or damaged ({printable(str(error))}); copy or record it again"
        ) from None


def _read(bag: Bag, connection: sqlite3.Connection, size: int) -> None:
    tables = {name for (name,) in connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
    if not {"topics", "messages"} <= tables:
        raise ValueError("it has no tables of topics and messages")
    definitions: dict[str, str] = {}
    if "message_definitions" in tables:
        rows = connection.execute("SELECT topic_type, encoding, encoded_message_definition FROM message_definitions")
        definitions = {kind: text for kind, encoding, text in rows if encoding == "ros2msg" and isinstance(text, str)}
    topics: dict[int, Topic] = {}
    for number, name, kind, encoding in connection.execute("SELECT id, name, type, serialization_format FROM topics"):
        if not (isinstance(number, int) and isinstance(name, str) and isinstance(kind, str)):
            raise ValueError("a topic without a name")
        topic = bag.topic(name, kind, str(encoding), definitions.get(kind, ""))
        if topic is not None:
            topics[number] = topic
    wanted = ", ".join(map(str, topics))
    read = 0
    # In the order of arrival. The numbers are ours; a name of the file never gets into the query.
    for topic_id, log_ns, data in connection.execute(
        f"SELECT topic_id, timestamp, data FROM messages WHERE topic_id IN ({wanted}) ORDER BY id"
    ):
        if not (isinstance(log_ns, int) and isinstance(data, bytes)):
            raise ValueError("a message without time or data")
        read += len(data) + 1
        if read > size:
            raise ValueError("pages that occur twice")
        bag.add(topics[topic_id], log_ns, data)
