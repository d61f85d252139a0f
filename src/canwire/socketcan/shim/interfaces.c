/* Names and numbers of interfaces: those of the table stand beside the kernel's own. */
#include "shim.h"

#include <errno.h>
#include <ifaddrs.h>
#include <linux/can.h>
#include <linux/sockios.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#ifndef ARPHRD_CAN
#define ARPHRD_CAN 280
#endif
#define QUEUE_LENGTH 1000

static unsigned flags_of(const struct interface *interface)
{
    unsigned running = interface->flags & INTERFACE_OFF ? 0 : IFF_RUNNING;

    return IFF_NOARP | (interface->flags & INTERFACE_UP ? IFF_UP | running : 0);
}

/* 1: about one of ours, and answered; -1: likewise, with errno; 0: the kernel's. */
static int answer(int fd, unsigned long request, struct ifreq *about)
{
    struct interface *interface =
        request == SIOCGIFNAME ? interface_by_index(about->ifr_ifindex) : interface_by_name(about->ifr_name);

    if (interface == NULL)
        return 0;
    switch (request) {
    case SIOCGIFNAME: strncpy(about->ifr_name, interface->name, IFNAMSIZ); return 1;
    case SIOCGIFINDEX: about->ifr_ifindex = interface->index; return 1;
    case SIOCGIFMTU: about->ifr_mtu = interface->mtu; return 1;
    case SIOCGIFFLAGS: about->ifr_flags = (short)flags_of(interface); return 1;
    case SIOCGIFTXQLEN: about->ifr_qlen = QUEUE_LENGTH; return 1;
    case SIOCGIFHWADDR:
        memset(&about->ifr_hwaddr, 0, sizeof about->ifr_hwaddr);
        about->ifr_hwaddr.sa_family = ARPHRD_CAN;
        return 1;
    case SIOCGIFMETRIC: about->ifr_metric = 0; return 1;
    case SIOCGIFMAP: memset(&about->ifr_map, 0, sizeof about->ifr_map); return 1;
    case SIOCGIFADDR:
    case SIOCGIFDSTADDR:
    case SIOCGIFNETMASK:
    case SIOCGIFBRDADDR: errno = slot_of(fd) != NULL ? ENOTTY : EADDRNOTAVAIL; return -1; /* IP's, not CAN's */
    case SIOCSIFFLAGS:
    case SIOCSIFMTU:
    case SIOCSIFTXQLEN:
    case SIOCSIFNAME: errno = EPERM; return -1;
    default: errno = EOPNOTSUPP; return -1;
    }
}

static int last_stamp(const struct slot *slot, unsigned long request, void *into)
{
    uint64_t stamp_ns = __atomic_load_n(&slot->last_stamp_ns, __ATOMIC_RELAXED);
    struct timespec fine = {(time_t)(stamp_ns / 1000000000), (long)(stamp_ns % 1000000000)};
    struct timeval coarse = {fine.tv_sec, fine.tv_nsec / 1000};

    if (stamp_ns == 0) {
        errno = ENOENT;
        return -1;
    }
    if (request == SIOCGSTAMP_OLD)
        memcpy(into, &coarse, sizeof coarse);
    else
        memcpy(into, &fine, sizeof fine);
    return 0;
}

static int about_interfaces(unsigned long request)
{
    switch (request) {
    case SIOCGIFNAME: case SIOCGIFINDEX: case SIOCGIFMTU: case SIOCGIFFLAGS: case SIOCGIFTXQLEN: case SIOCGIFHWADDR:
    case SIOCSIFFLAGS: case SIOCSIFMTU: case SIOCSIFTXQLEN: case SIOCSIFNAME: case SIOCGIFADDR:
    case SIOCGIFMETRIC: case SIOCGIFMAP: case SIOCGIFDSTADDR: case SIOCGIFNETMASK: case SIOCGIFBRDADDR:
        return 1;
    default:
        return 0;
    }
}

EXPORT int ioctl(int fd, unsigned long request, ...)
{
    va_list rest;
    void *argument;

    va_start(rest, request);
    argument = va_arg(rest, void *);
    va_end(rest);
    if (shim_table != NULL && about_interfaces(request) && argument != NULL) {
        struct ifreq about;
        if (copy_in(&about, argument, sizeof about) != 0)
            return REAL(ioctl)(fd, request, argument); /* EFAULT */
        int found = answer(fd, request, &about);
        if (found > 0 && copy_out(argument, &about, sizeof about) == 0)
            return 0;
        if (found > 0)
            errno = EFAULT;
        if (found != 0)
            return -1;
    } else if (shim_table != NULL &&
               (request == SIOCGSTAMP_OLD || request == SIOCGSTAMPNS_OLD || request == FIONREAD ||
                request == SIOCOUTQ)) {
        struct slot *slot = slot_of(fd);
        if (slot != NULL && request != FIONREAD && request != SIOCOUTQ)
            return last_stamp(slot, request, argument);
        if (slot != NULL) {
            errno = ENOTTY; /* as of a kernel's CAN socket */
            return -1;
        }
    }
    return REAL(ioctl)(fd, request, argument);
}

EXPORT unsigned if_nametoindex(const char *name)
{
    struct interface *interface = interface_by_name(name);

    return interface != NULL ? (unsigned)interface->index : REAL(if_nametoindex)(name);
}

EXPORT char *if_indextoname(unsigned index, char name[IF_NAMESIZE])
{
    struct interface *interface = interface_by_index((int)index);

    return interface != NULL ? strncpy(name, interface->name, IF_NAMESIZE) : REAL(if_indextoname)(index, name);
}

/* One block: the entries, the one that ends them, and the names. */
EXPORT struct if_nameindex *if_nameindex(void)
{
    struct if_nameindex *theirs = REAL(if_nameindex)(), *all;
    size_t own = shim_table != NULL ? shim_table->interfaces : 0, others = 0, at = 0;
    char(*names)[IF_NAMESIZE];

    if (theirs == NULL)
        return NULL;
    while (theirs[others].if_index != 0)
        others++;
    all = calloc(1, (own + others + 1) * (sizeof *all + IF_NAMESIZE));
    if (all != NULL) {
        names = (void *)(all + own + others + 1);
        for (size_t k = 0; k < others; k++, at++) {
            all[at].if_index = theirs[k].if_index;
            all[at].if_name = strncpy(names[at], theirs[k].if_name, IF_NAMESIZE - 1);
        }
        for (size_t k = 0; k < own; k++)
            if (!(shim_table->interface[k].flags & INTERFACE_GONE)) {
                all[at].if_index = (unsigned)shim_table->interface[k].index;
                all[at].if_name = strncpy(names[at], shim_table->interface[k].name, IF_NAMESIZE - 1);
                at++;
            }
    }
    REAL(if_freenameindex)(theirs);
    return all;
}

EXPORT void if_freenameindex(struct if_nameindex *all)
{
    free(all);
}

struct own_address { /* without an address, which CAN has none of */
    struct ifaddrs entry;
    char name[IF_NAMESIZE];
};

static struct own_address *made_of(const struct interface *interface)
{
    struct own_address *made = calloc(1, sizeof *made);

    if (made != NULL) {
        memcpy(made->name, interface->name, sizeof interface->name);
        made->entry.ifa_name = made->name;
        made->entry.ifa_flags = flags_of(interface);
    }
    return made;
}

/* Ours come first, so that the C library's list stays as it is, for its own function to free. */
EXPORT int getifaddrs(struct ifaddrs **all)
{
    struct own_address *made;

    if (REAL(getifaddrs)(all) < 0)
        return -1;
    for (uint32_t at = shim_table != NULL ? shim_table->interfaces : 0; at-- > 0;)
        if (!(shim_table->interface[at].flags & INTERFACE_GONE) &&
            (made = made_of(&shim_table->interface[at])) != NULL) {
            made->entry.ifa_next = *all;
            *all = &made->entry;
        }
    return 0;
}

EXPORT void freeifaddrs(struct ifaddrs *all)
{
    while (all != NULL && all->ifa_name == ((struct own_address *)all)->name) {
        struct ifaddrs *next = all->ifa_next;
        free(all);
        all = next;
    }
    REAL(freeifaddrs)(all);
}
