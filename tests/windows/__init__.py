"""Programs on CPython for Windows, under Wine: `bash .ci/windows` makes it, and runs these."""
