/* Waiting for handles, one or all of some. */
#include "core.h"

#include <string.h>

#define MOST 64 /* MAXIMUM_WAIT_OBJECTS */

static int signalled(struct cw_object *object)
{
    struct pollfd about = {object->kind->descriptor(object), POLLIN, 0};

    return poll(&about, 1, 0) > 0;
}

static int all_signalled(struct cw_object **objects, uint32_t count)
{
    for (uint32_t k = 0; k < count; k++)
        if (!signalled(objects[k]))
            return 0;
    return 1;
}

/* Index of what was taken, or -1. Another thread may take one of several between a look and the taking: then the others
 * are taken all the same, and what is missing is waited for. */
static int take_one(struct cw_object **objects, uint32_t count)
{
    for (uint32_t k = 0; k < count; k++)
        if (objects[k] != NULL && objects[k]->kind->take(objects[k]))
            return (int)k;
    return -1;
}

static int take_all(struct cw_object **objects, uint32_t count, uint64_t *missing)
{
    if (*missing == (count == MOST ? ~0ull : (1ull << count) - 1) && !all_signalled(objects, count))
        return 0;
    for (uint32_t k = 0; k < count; k++)
        if (*missing & 1ull << k && objects[k]->kind->take(objects[k]))
            *missing &= ~(1ull << k);
    return *missing == 0;
}

static int wait_for(struct cw_object **objects, uint32_t count, int all, int64_t until)
{
    struct pollfd about[MOST + 1];
    uint64_t missing = count == MOST ? ~0ull : (1ull << count) - 1;

    for (;;) {
        uint32_t polled = 0, process = cw_process();
        int one = 0;

        if (all ? take_all(objects, count, &missing) : (one = take_one(objects, count)) >= 0)
            return all ? 0 : one;
        for (uint32_t k = 0; k < count; k++)
            if (!all || (missing & 1ull << k && !signalled(objects[k])))
                about[polled++] = (struct pollfd){objects[k]->kind->descriptor(objects[k]), POLLIN, 0};
        if (polled == 0)
            continue; /* all of them are there by now */
        about[polled] = (struct pollfd){cw_lifeline(), POLLIN, 0};
        if (cw_poll(about, polled + 1, until) == 0)
            return CW_WAIT_TIMEOUT;
        if (about[polled].revents)
            cw_helper_gone(process); /* events of its rings are signalled from now on */
    }
}

int cw_wait(cw_handle const *handles, uint32_t count, int all, int64_t milliseconds)
{
    struct cw_object *objects[MOST];
    uint32_t got = 0;
    int result = CW_WAIT_FAILED;

    if (handles == NULL || count == 0 || count > MOST)
        return CW_WAIT_FAILED;
    for (; got < count; got++) {
        objects[got] = cw_handle_get(handles[got], NULL);
        if (objects[got] == NULL)
            break;
        if (objects[got]->kind->take == NULL) {
            cw_object_release(objects[got]);
            break;
        }
    }
    if (got == count)
        result = wait_for(objects, count, all && count > 1, cw_deadline(milliseconds));
    while (got > 0)
        cw_object_release(objects[--got]);
    return result;
}
