/* Memory that does not move: on Linux, any. */
#include "acan_core.h"

#include <pthread.h>

struct piece {
    void *at;
    UINT size;
    struct piece *next;
};

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static struct piece *pieces;

LPVOID ACAN_AllocFixedMemory(UINT size)
{
    struct piece *made = size > 0 ? malloc(sizeof *made) : NULL;

    if (made == NULL)
        return NULL;
    *made = (struct piece){calloc(1, size), size, NULL};
    if (made->at == NULL) {
        free(made);
        return NULL;
    }
    pthread_mutex_lock(&lock);
    made->next = pieces;
    pieces = made;
    pthread_mutex_unlock(&lock);
    return made->at;
}

BOOL ACAN_FreeFixedMemory(LPVOID at, UINT size)
{
    struct piece *found = NULL;

    pthread_mutex_lock(&lock);
    for (struct piece **here = &pieces; *here != NULL; here = &(*here)->next)
        if ((*here)->at == at && (*here)->size == size) {
            found = *here;
            *here = found->next;
            break;
        }
    pthread_mutex_unlock(&lock);
    if (found == NULL)
        return FALSE;
    free(found->at);
    free(found);
    return TRUE;
}
