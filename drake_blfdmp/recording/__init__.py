"""MCAP out and in.

run_log         the arrays that metrics and figures are computed from
mcap_recorder   McapRecorder, the LeafSystem that records a run
plant_names     what of a plant is recorded, and under which names
mcap_file       the file under construction: chunks, metadata, attachments
read            read_mcap: a recording back in arrays, a damaged one up to the break
"""
