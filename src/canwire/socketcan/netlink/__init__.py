"""rtnetlink as programs under `canwire run` have it: the server's interfaces beside the kernel's own."""
