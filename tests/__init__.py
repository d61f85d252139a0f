"""What must be so before anything else of the tests is imported."""

import os
import sys

if os.environ.get("PYTHONDONTWRITEBYTECODE") == "1":
    # Images of containers set it so. Here it costs more than it saves: each worker rewrites the assertions of all tests
    # anew, each of a thousand processes compiles the program. A user who means it for tests too says "always".
    del os.environ["PYTHONDONTWRITEBYTECODE"]
    sys.dont_write_bytecode = False
