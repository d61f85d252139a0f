/* How structures are packed from here on; no guard: it is included many times. */
#pragma pack(pop)
