"""Names and signals of frames from a network description: DBC, ARXML, KCD, SYM and LDF files as one `Database`.

`loading.py` reads files; only `can_file.py` uses cantools, and only `lin_file.py` uses ldfparser. `description.py`
describes messages and signals, `matching.py` finds the message of a frame, `values_in.py` checks values, `columns.py`
decodes many frames in one call with numpy, and `port.py` sends and receives by name on a node or channel.
"""
