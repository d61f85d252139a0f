/* DeviceIoControl, and what serial lines have: timeouts, masks, waiting for an event. */
#include "candrv.h"

#define MOST 4096 /* bytes that go in or out; the largest structure has fewer */

static DWORD least(DWORD count)
{
    return count < MOST ? count : MOST;
}

/* The out buffer goes along as it is, since two codes read it; back comes what is there now. */
int DeviceIoControl(HANDLE handle, DWORD code, LPVOID in, DWORD in_size, LPVOID out, DWORD out_size, LPDWORD returned,
                    LPOVERLAPPED overlapped)
{
    struct {
        DWORD code, in_size, in_given, out_size, out_given;
        char data[2 * MOST];
    } asked;
    struct {
        DWORD returned;
        char data[MOST];
    } answer;
    DWORD before = in != NULL ? least(in_size) : 0, room = out != NULL ? least(out_size) : 0;
    uint32_t number = device_number(handle);
    struct cw_call call = {.method = "candrv.device_io_control", .object = number, .in = &asked,
                           .in_size = 20 + before + room, .out = &answer, .out_size = sizeof answer};
    BOOL done;

    (void)overlapped;
    if (returned != NULL)
        *returned = 0;
    if (number == 0)
        return 0;
    asked.code = code;
    asked.in_size = in_size;
    asked.in_given = in != NULL;
    asked.out_size = out_size;
    asked.out_given = out != NULL;
    answer.returned = 0;
    if (before > 0)
        memcpy(asked.data, in, before);
    if (room > 0)
        memcpy(asked.data + before, out, room);
    done = device_call(&call);
    if (call.out_length > sizeof answer.returned && call.out_length - sizeof answer.returned <= room)
        memcpy(out, answer.data, call.out_length - sizeof answer.returned);
    if (returned != NULL)
        *returned = answer.returned;
    return done ? (int)call.value : 0; /* of IOCTL_CAN_TEST_DEVICE 0 is an answer, too */
}

/* A call with one structure in or out, whose pointer may be NULL. */
static BOOL simple(HANDLE handle, const char *method, const void *in, size_t in_size, void *out, size_t out_size,
                   uint32_t *value)
{
    uint32_t number = device_number(handle);
    struct cw_call call = {.method = method, .object = number, .in = in, .in_size = in != NULL ? in_size : 0,
                           .out = out, .out_size = out != NULL ? out_size : 0};

    if (number == 0 || !device_call(&call))
        return FALSE;
    if (value != NULL)
        *value = call.value;
    return TRUE;
}

BOOL SetCommTimeouts(HANDLE handle, LPCOMMTIMEOUTS timeouts)
{
    return simple(handle, "candrv.set_comm_timeouts", timeouts, sizeof *timeouts, NULL, 0, NULL);
}

BOOL GetCommTimeouts(HANDLE handle, LPCOMMTIMEOUTS timeouts)
{
    uint32_t given = timeouts != NULL;

    return simple(handle, "candrv.get_comm_timeouts", &given, sizeof given, timeouts, sizeof *timeouts, NULL);
}

BOOL SetCommMask(HANDLE handle, DWORD mask)
{
    return simple(handle, "candrv.set_comm_mask", &mask, sizeof mask, NULL, 0, NULL);
}

BOOL GetCommMask(HANDLE handle, LPDWORD mask)
{
    return simple(handle, "candrv.get_comm_mask", NULL, 0, NULL, 0, mask);
}

BOOL WaitCommEvent(HANDLE handle, LPDWORD event, LPOVERLAPPED overlapped)
{
    (void)overlapped;
    if (event != NULL)
        *event = 0;
    return simple(handle, "candrv.wait_comm_event", NULL, 0, NULL, 0, event);
}
