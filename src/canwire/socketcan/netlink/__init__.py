"""rtnetlink for programs under `canwire run`: the server's interfaces together with those of the kernel."""
