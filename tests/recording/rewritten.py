"""A recording written anew with something else in it, by the independent library."""

from pathlib import Path

from mcap.reader import make_reader
from mcap.writer import Writer


def rewrite(
    source: Path,
    target: Path,
    *,
    message=lambda topic, t_ns, data: (t_ns, data),
    schema=lambda topic, name: name,
    metadata=lambda name, entries: entries,
    attachment=lambda name, data: data,
    profile: str = "ros2",
) -> Path:
    """Every function may return None to leave out what it is given."""
    with source.open("rb") as stream, target.open("xb") as out:
        reader, writer = make_reader(stream), Writer(out)
        writer.start(profile=profile, library="test")
        for record in reader.iter_metadata():
            entries = metadata(record.name, record.metadata)
            if entries is not None:
                writer.add_metadata(record.name, entries)
        for record in reader.iter_attachments():
            data = attachment(record.name, record.data)
            if data is not None:
                writer.add_attachment(0, 0, record.name, record.media_type, data)
        channels = {}
        for kind, channel, record in reader.iter_messages(log_time_order=False):
            made = message(channel.topic, record.log_time, record.data)
            if made is None:
                continue
            if channel.id not in channels:
                name = schema(channel.topic, kind.name)
                number = writer.register_schema(name=name, encoding=kind.encoding, data=kind.data)
                channels[channel.id] = writer.register_channel(channel.topic, "cdr", number, channel.metadata)
            t_ns, data = made
            writer.add_message(channels[channel.id], t_ns, data, t_ns)
        writer.finish()
    return target
