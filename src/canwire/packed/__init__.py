"""C structures as bytes: little-endian, packed or aligned as a compiler does, each declared once.

layout.py puts fields into memory, kinds.py has the kinds of field that more than one dialect knows, record.py the
structures whose fields are checked when they are assigned. VCI's are checked when they are packed, as its own
functions would: those stand in vci/structures/, over the same layout.
"""
