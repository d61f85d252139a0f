"""Programs that preload nothing: the kernel stops their calls for CAN, and the server answers these (seccomp)."""
