/* The library itself, the hardware and the bus. */
#include "acan_core.h"

uint32_t acan_helper;

BOOL acan_call(struct cw_call *call)
{
    return cw_call(call) == 0 && call->result == 0;
}

static WORD word(const char *method, uint32_t value)
{
    struct cw_call call = {.method = method, .in = &value, .in_size = sizeof value};

    return acan_call(&call) ? (WORD)call.value : 0;
}

WORD ACAN_Init(void)
{
    struct {
        uint32_t process, anew;
    } library = {0, 0};
    struct cw_call call = {.method = "acan.init", .out = &library, .out_size = sizeof library};

    if (!acan_call(&call))
        return 0;
    if (library.anew)
        acan_drop_all();
    __atomic_store_n(&acan_helper, library.process, __ATOMIC_RELEASE);
    return (WORD)call.value;
}

WORD ACAN_GetDriverVersion(void)
{
    return word("acan.get_driver_version", 0);
}

WORD ACAN_GetInitStatus(void)
{
    return word("acan.get_init_status", 0);
}

BOOL ACAN_SetHardConfig(LPACANHI hi)
{
    struct cw_call call = {.method = "acan.set_hard_config", .in = hi, .in_size = hi != NULL ? sizeof *hi : 0};

    return acan_call(&call);
}

BOOL ACAN_GetHardConfig(LPACANHI hi)
{
    ACANHI found;
    struct cw_call call = {.method = "acan.get_hard_config", .out = &found, .out_size = sizeof found};

    if (hi == NULL || !acan_call(&call) || call.out_length != sizeof found)
        return FALSE;
    *hi = found;
    return TRUE;
}

WORD ACAN_BusControl(BUS_STATE state)
{
    return word("acan.bus_control", (uint32_t)state);
}

void ACAN_Exit(void)
{
    struct cw_call call = {.method = "acan.exit"};

    if (__atomic_load_n(&acan_helper, __ATOMIC_ACQUIRE) == 0)
        return; /* no ACAN_Init; and no helper is started to be told so */
    acan_drop_all();
    acan_call(&call);
    __atomic_store_n(&acan_helper, 0, __ATOMIC_RELEASE);
}
