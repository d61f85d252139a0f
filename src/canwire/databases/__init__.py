"""Names and signals of frames by a network's description: DBC, ARXML, KCD, SYM and LDF files behind one `Database`.

`loading.py` reads files, with `can_file.py` over cantools and `lin_file.py` over ldfparser as the two that know those
libraries; `description.py` is what a file says, `matching.py` which message a frame is, `values_in.py` which values
fit, `columns.py` decodes many frames at once with numpy, `port.py` is a node or channel that speaks by name.
"""
