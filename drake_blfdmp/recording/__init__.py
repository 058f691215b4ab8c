"""MCAP out and in.

Written by:
mcap_recorder        McapRecorder, the LeafSystem that records a run
topic_recorder       its base, TopicRecorder: named vectors, wrenches, messages and events
topics               what a topic is, and where its numbers come from
plant_names          what of a plant is recorded, and under which names
pose_rows            many poses at once as ROS 2 writes them
sampler              what is read at every sample, held for a moment, and written
sample_block         the messages of a sample, and the ports their numbers come from
message_block        those messages, of many samples at once, as blocks of bytes
mcap_file            the file under construction
mcap_chunk           its chunks and its index, as bytes
journal              what of the chunk in progress a killed process leaves
planned_signals      what figures need of the plan, as an attachment

Read by:
stream, samples      McapStream: files of any length, sample by sample
read                 read_mcap: a whole recording in arrays
recover, mcap_copy   a complete file of one that was cut off
kind                 which kind of recording a file is
sample_table         the rows that are kept of several topics
run_log_from_file    read_run_log: a run's log from a recording alone, thinned where it is long
run_log              the arrays that metrics and figures are computed from
"""
