/* A warm helper: a process that has loaded all that a helper needs, and forks one for each program that asks.
 *
 * The first program's helper leaves it behind (../helper/warm.py), for as many seconds as CANWIRE_HELPER_STAYS says. Only
 * programs ask it that would start the same: of this user, with this Python and library, and in the same namespaces.
 */
#include "core.h"
#include "start.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#define SECONDS "10" /* that it stays where nothing else is said */
#define PATIENCE_S 2  /* for its answer; then a cold one is quicker */
#define MOST_BYTES 150000 /* of variables: what a socket takes as one message */

static uint64_t mixed(uint64_t hash, const char *bytes, size_t count) /* FNV-1a */
{
    for (size_t k = 0; k < count; k++)
        hash = (hash ^ (unsigned char)bytes[k]) * 0x100000001b3u;
    return hash;
}

static uint64_t mixed_file(uint64_t hash, const char *path, int link)
{
    char content[4096];
    int file = link ? -1 : open(path, O_RDONLY | O_CLOEXEC);
    ssize_t got = link ? readlink(path, content, sizeof content) : file < 0 ? -1 : read(file, content, sizeof content);

    if (file >= 0)
        close(file);
    return mixed(hash, content, got > 0 ? (size_t)got : 0);
}

/* What an interpreter and its modules look at while they start. */
static int matters(const char *variable)
{
    return strncmp(variable, "PYTHON", 6) == 0 || strncmp(variable, "LD_", 3) == 0 ||
           strncmp(variable, "CANWIRE_PLATFORM=", 17) == 0;
}

/* "": none is wanted. */
void cw_warm_name(char name[CW_WARM_NAME], const char *python, const char *library, char *const settings[])
{
    const char *stays = getenv("CANWIRE_HELPER_STAYS");
    uint64_t hash = mixed(0xcbf29ce484222325u, python, strlen(python) + 1);
    struct stat about = {0};

    name[0] = '\0';
    if (stays == NULL || *stays == '\0')
        stays = SECONDS;
    if (strtod(stays, NULL) <= 0)
        return;
    hash = mixed(hash, library, strlen(library) + 1);
    stat(library, &about);
    hash = mixed(hash, (char *)&about.st_mtim, sizeof about.st_mtim);
    stat("/", &about);
    hash = mixed(hash, (char *)&about.st_ino, sizeof about.st_ino);
    hash = mixed(hash, (char *)&about.st_dev, sizeof about.st_dev);
    hash = mixed_file(hash, "/proc/self/ns/mnt", 1);
    hash = mixed_file(hash, "/proc/self/ns/pid", 1);
    hash = mixed_file(hash, "/proc/self/ns/user", 1);
    hash = mixed_file(hash, "/proc/self/cgroup", 0);
    for (; *settings != NULL; settings++)
        if (matters(*settings))
            hash = mixed(hash, *settings, strlen(*settings) + 1);
    snprintf(name, CW_WARM_NAME, "canwire-helper-%u-%016llx-%.8s", (unsigned)getuid(), (unsigned long long)hash, stays);
}

static int asked(const char *name)
{
    struct sockaddr_un where = {.sun_family = AF_UNIX};
    struct timeval patience = {PATIENCE_S, 0};
    struct ucred who;
    socklen_t size = sizeof who;
    size_t length = strlen(name);
    int asking = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);

    if (asking < 0)
        return -1;
    memcpy(where.sun_path + 1, name, length); /* in the abstract namespace: nothing to clear away */
    setsockopt(asking, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    setsockopt(asking, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
    if (connect(asking, (struct sockaddr *)&where, (socklen_t)(offsetof(struct sockaddr_un, sun_path) + 1 + length)) < 0 ||
        getsockopt(asking, SOL_SOCKET, SO_PEERCRED, &who, &size) < 0 || who.uid != getuid()) {
        close(asking);
        return -1;
    }
    return asking;
}

/* What a helper has to know, one after the other, each with a zero: process, name, variables. */
static char *described(size_t *size, char *const words[], char *const settings[])
{
    char *all = malloc(MOST_BYTES), *at = all;

    for (int k = 0; at != NULL && (k < 2 || settings[k - 2] != NULL); k++) {
        const char *one = k < 2 ? words[k] : settings[k - 2];
        size_t length = strlen(one) + 1;
        if ((size_t)(at - all) + length > MOST_BYTES) {
            free(all);
            return NULL;
        }
        at = (char *)memcpy(at, one, length) + length;
    }
    *size = (size_t)(at - all);
    return all;
}

static int hand_over(int asking, char *bytes, size_t size, const int descriptors[3])
{
    union {
        struct cmsghdr header;
        char room[CMSG_SPACE(3 * sizeof(int))];
    } control = {.header = {.cmsg_len = CMSG_LEN(3 * sizeof(int)), .cmsg_level = SOL_SOCKET, .cmsg_type = SCM_RIGHTS}};
    struct iovec one = {bytes, size};
    struct msghdr message = {.msg_iov = &one, .msg_iovlen = 1, .msg_control = &control, .msg_controllen = sizeof control.room};
    char done;

    memcpy(CMSG_DATA(&control.header), descriptors, 3 * sizeof(int));
    if (sendmsg(asking, &message, MSG_NOSIGNAL) < 0 || recv(asking, &done, 1, 0) != 1)
        return -1;
    return send(asking, &done, 1, MSG_NOSIGNAL) == 1 ? 0 : -1; /* until here it does nothing: a cold one may be started */
}

int cw_warm_start(const char *name, int channel, char *const words[], char *const settings[])
{
    size_t size = 0;
    int descriptors[3], result = -1, asking = asked(name);
    char *bytes;

    if (asking < 0)
        return -1;
    descriptors[0] = channel;
    descriptors[1] = fcntl(2, F_DUPFD_CLOEXEC, 3);
    if (descriptors[1] < 0)
        descriptors[1] = open("/dev/null", O_WRONLY | O_CLOEXEC);
    descriptors[2] = open(".", O_PATH | O_DIRECTORY | O_CLOEXEC);
    bytes = described(&size, words, settings);
    if (bytes != NULL && descriptors[1] >= 0 && descriptors[2] >= 0)
        result = hand_over(asking, bytes, size, descriptors);
    free(bytes);
    for (int k = 1; k < 3; k++)
        if (descriptors[k] >= 0)
            close(descriptors[k]);
    close(asking);
    return result;
}
