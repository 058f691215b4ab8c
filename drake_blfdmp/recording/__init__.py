"""MCAP out and in.

run_log         the arrays that metrics and figures are computed from
run_log_from_file  read_run_log: that log from a recording alone, thinned where it is long
sample_table    the rows that are kept of several topics
planned_signals what figures need of the plan, as an attachment
kind            which kind of recording a file is
mcap_recorder   McapRecorder, the LeafSystem that records a run
event_recorder  EventRecorder: an event whenever a number that stands for a name changes
sample_block    the messages of a sample, and the ports their numbers come from
plant_names     what of a plant is recorded, and under which names
mcap_file       the file under construction: chunks, metadata, attachments
read            read_mcap: a recording back in arrays, a damaged one up to the break
"""
