"""Acceptance filter vectors of the SJA1000, copied from reference/sja1000.md section 13.

Mode B BasicCAN, S single filter, D dual filter. There: F01-F05 from data sheet 6.3.9 and 6.2.1.4;
F06-F18 from 6.4.15.1; F19-F27 from 6.4.15.2; F28-F36 the example of the CANBUS manual read with 6.4.15.2.
"""

# number, mode, ACR, AMR, identifier (3 digits 11-bit, 8 digits 29-bit), remote, data, accepted
VECTORS = [
    ("F01", "B", "A5", "00", "52F", False, "", True),
    ("F02", "B", "A5", "00", "528", True, "", True),
    ("F03", "B", "A5", "00", "530", False, "", False),
    ("F04", "B", "A5", "0F", "557", False, "", True),
    ("F05", "B", "A5", "FF", "0000052F", False, "", False),
    ("F06", "S", "24600000", "000FFFFF", "123", False, "", True),
    ("F07", "S", "24600000", "000FFFFF", "123", True, "", False),
    ("F08", "S", "24600000", "001FFFFF", "123", True, "", True),
    ("F09", "S", "24601122", "000F0000", "123", False, "1122", True),
    ("F10", "S", "24601122", "000F0000", "123", False, "1123", False),
    ("F11", "S", "24601122", "000F0000", "123", False, "11", True),
    ("F12", "S", "24601122", "000F0000", "123", False, "", True),
    ("F13", "S", "246F1122", "00000000", "123", False, "1122", True),
    ("F14", "S", "91A2B3C0", "00000003", "12345678", False, "", True),
    ("F15", "S", "91A2B3C0", "00000003", "12345678", True, "", False),
    ("F16", "S", "91A2B3C0", "00000007", "12345678", True, "", True),
    ("F17", "S", "91A2B3C0", "00000003", "12345679", False, "", False),
    ("F18", "S", "91A2B3C3", "00000000", "12345678", False, "", True),
    ("F19", "D", "24653CC7", "00000000", "123", False, "57", True),
    ("F20", "D", "24653CC7", "00000000", "123", False, "58", False),
    ("F21", "D", "24653CC7", "00000000", "123", False, "", True),
    ("F22", "D", "24653CC7", "00000000", "1E6", False, "99", True),
    ("F23", "D", "24653CC7", "00000000", "1E6", True, "", False),
    ("F24", "D", "91A20A55", "00000000", "12345678", False, "", True),
    ("F25", "D", "91A20A55", "00000000", "12345FFF", True, "", True),
    ("F26", "D", "91A20A55", "00000000", "12346000", False, "", False),
    ("F27", "D", "91A20A55", "00000000", "014ABFFF", False, "", True),
    ("F28", "D", "00006000", "00001FF0", "300", False, "00", True),
    ("F29", "D", "00006000", "00001FF0", "3FF", True, "", True),
    ("F30", "D", "00006000", "00001FF0", "400", False, "", False),
    ("F31", "D", "00006000", "00001FF0", "000", False, "00", True),
    ("F32", "D", "00006000", "00001FF0", "000", False, "01", False),
    ("F33", "D", "00006000", "00001FE0", "345", True, "", False),
    ("F34", "D", "00006000", "00001FF0", "00001ABC", False, "", True),
    ("F35", "D", "00006000", "00001FF0", "0C001234", False, "", True),
    ("F36", "D", "00006000", "00001FF0", "0C002000", False, "", False),
]
