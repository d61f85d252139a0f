"""Rings that AF_PACKET programs map: frames in the layouts of linux/if_packet.h."""
