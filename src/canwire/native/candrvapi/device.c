/* A device's handle: a number of the helper's, which knows all of CANDRV's rules (../candrv/). */
#include "candrv.h"

#include <stdio.h>
#include <unistd.h>

#define MOST_NAME 1000
#define PIECE 32768 /* of a text that is written: messages may go over the edge of a call */

struct device {
    struct cw_object object;
    uint32_t number;
    uint32_t process;
    pid_t owner;
};

static void destroy(struct cw_object *object)
{
    struct device *device = (struct device *)object;
    struct cw_call call = {.method = "candrv.close", .object = device->number};

    if (device->process == cw_process())
        cw_call(&call); /* nobody is left who could be told of a failure */
    free(device);
}

static const struct cw_kind device_kind = {"CAN device", destroy, NULL, NULL};

BOOL device_call(struct cw_call *call)
{
    if (cw_call(call) < 0)
        return candrv_fail(ERROR_DEV_NOT_EXIST);
    return call->result == 0 ? TRUE : candrv_fail((DWORD)call->result);
}

static HANDLE handle_of(uint32_t number, uint32_t process)
{
    struct device *device = malloc(sizeof *device);
    cw_handle handle = NULL;

    if (device != NULL) {
        *device = (struct device){{&device_kind, 1}, number, process, getpid()};
        handle = cw_handle_new(&device->object);
        if (handle == NULL)
            cw_object_release(&device->object);
    }
    if (handle == NULL) {
        SetLastError(ERROR_NOT_ENOUGH_MEMORY);
        return INVALID_HANDLE_VALUE;
    }
    return handle;
}

HANDLE device_open(LPCSTR name, DWORD access, DWORD share, DWORD creation)
{
    struct {
        DWORD access, share, creation;
        char name[MOST_NAME];
    } asked = {access, share, creation, ""};
    size_t length = strlen(name);
    uint32_t process = cw_process();
    struct cw_call call = {.method = "candrv.create_file", .in = &asked, .in_size = 12 + length};

    if (length > sizeof asked.name) {
        SetLastError(ERROR_FILE_NOT_FOUND);
        return INVALID_HANDLE_VALUE;
    }
    memcpy(asked.name, name, length);
    if (!device_call(&call))
        return INVALID_HANDLE_VALUE;
    return handle_of(call.value, process);
}

uint32_t device_number(HANDLE handle)
{
    struct device *found = (struct device *)cw_handle_get(handle, &device_kind);
    uint32_t number = 0;

    if (found == NULL)
        return (uint32_t)candrv_fail(ERROR_INVALID_HANDLE);
    if (found->process == cw_process())
        number = found->number;
    else /* a fork has no handles of its parent's; else the helper has ended, and the device with it */
        SetLastError(found->owner != getpid() ? ERROR_INVALID_HANDLE : ERROR_DEV_NOT_EXIST);
    cw_object_release(&found->object);
    return number;
}

BOOL device_read(uint32_t number, LPVOID buffer, DWORD count, LPDWORD read)
{
    DWORD asked[2] = {count, buffer != NULL};
    struct cw_call call = {.method = "candrv.read_file", .object = number, .in = asked, .in_size = sizeof asked,
                           .out = buffer, .out_size = buffer != NULL ? count : 0};

    if (!device_call(&call))
        return FALSE;
    if (call.out_length < call.out_size)
        ((char *)buffer)[call.out_length] = '\0'; /* CanRead prints it as a string */
    if (read != NULL)
        *read = (DWORD)call.out_length;
    return TRUE;
}

static BOOL write_piece(uint32_t number, LPCVOID buffer, DWORD count, LPDWORD written)
{
    struct {
        DWORD count, given;
        char text[PIECE];
    } asked;
    struct cw_call call = {.method = "candrv.write_file", .object = number, .in = &asked, .in_size = 8};
    BOOL done;

    asked.count = count;
    asked.given = buffer != NULL;
    if (buffer != NULL) {
        memcpy(asked.text, buffer, count);
        call.in_size += count;
    }
    done = device_call(&call);
    *written = call.value;
    return done;
}

BOOL device_write(uint32_t number, LPCVOID buffer, DWORD count, LPDWORD written)
{
    DWORD sum = 0, here;
    BOOL done;

    do {
        DWORD piece = count - sum < PIECE || buffer == NULL ? count - sum : PIECE;

        done = write_piece(number, buffer != NULL ? (const char *)buffer + sum : NULL, piece, &here);
        sum += here;
    } while (done && sum < count && here > 0);
    if (written != NULL)
        *written = sum;
    return done;
}
