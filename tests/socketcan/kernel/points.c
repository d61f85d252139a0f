// What the kernel does with CAN sockets, observed call by call: prints "point: value" lines, no judgement.
// Run it with a kernel's vcan0 vcan1, run it under `canwire run --interface vcan0=can0 --interface vcan1=can1`, diff.
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <ifaddrs.h>
#include <linux/can.h>
#include <linux/can/bcm.h>
#include <linux/can/isotp.h>
#include <linux/can/raw.h>
#include <linux/filter.h>
#include <linux/net_tstamp.h>
#include <linux/sockios.h>
#include <net/if.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/ioctl.h>
#include <sys/select.h>
#include <sys/sendfile.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <sys/uio.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static const char *if0 = "vcan0", *if1 = "vcan1";
static const char *section = "";
static void out(const char *name, const char *fmt, ...)
{
    va_list a; va_start(a, fmt);
    printf("%s.%s: ", section, name); vprintf(fmt, a); printf("\n"); fflush(stdout);
    va_end(a);
}
static char ebuf[8][64]; static int eat;
static const char *E(long r) // a call's result, or its errno
{
    char *b = ebuf[eat++ & 7];
    int e = errno;
    if (r >= 0) snprintf(b, 64, "%ld", r); else snprintf(b, 64, "-%s", strerrorname_np(e) ?: "?");
    errno = e;
    return b;
}
static double now(void) { struct timespec t; clock_gettime(CLOCK_MONOTONIC, &t); return t.tv_sec + t.tv_nsec / 1e9; }
static void ms(int n) { usleep(n * 1000); }
static struct sockaddr_can addr_of(int index) { struct sockaddr_can a = {.can_family = AF_CAN, .can_ifindex = index}; return a; }
static int index0(void) { return if_nametoindex(if0); }
static int index1(void) { return if_nametoindex(if1); }
static int raw(void) { int s = socket(AF_CAN, SOCK_RAW, CAN_RAW); if (s < 0) { out("socket", "%s", E(s)); exit(0); } return s; }
static int raw_on(int index)
{
    int s = raw(); struct sockaddr_can a = addr_of(index);
    if (bind(s, (void *)&a, sizeof a) < 0) { out("bind", "%s", E(-1)); exit(0); }
    return s;
}
static int set(int s, int level, int name, int v) { return setsockopt(s, level, name, &v, sizeof v); }
static struct can_frame frame(unsigned id, int len, int first)
{
    struct can_frame f; memset(&f, 0, sizeof f); f.can_id = id; f.can_dlc = len;
    for (int i = 0; i < 8 && i < len; i++) f.data[i] = first + i;
    return f;
}
static long put(int s, unsigned id, int len, int first) { struct can_frame f = frame(id, len, first); return write(s, &f, sizeof f); }
static int ready(int s, int t) { struct pollfd p = {s, POLLIN, 0}; return poll(&p, 1, t) > 0 && p.revents & POLLIN; }
static int drain(int s, int t) { char b[2048]; int n = 0; while (ready(s, t) && recv(s, b, sizeof b, MSG_DONTWAIT) >= 0) n++; return n; }

static void s_socket(void)
{
    static const struct { int type, proto; } c[] = {{SOCK_RAW, 1}, {SOCK_DGRAM, 1}, {SOCK_STREAM, 1}, {SOCK_SEQPACKET, 1}, {SOCK_RAW, 0}, {SOCK_DGRAM, 2},
        {SOCK_RAW, 2}, {SOCK_DGRAM, 6}, {SOCK_RAW, 6}, {SOCK_SEQPACKET, 6}, {SOCK_DGRAM, 3}, {SOCK_RAW, 8}, {SOCK_RAW, -1}, {SOCK_RAW, 100}, {77, 1}};
    for (unsigned i = 0; i < sizeof c / sizeof *c; i++) {
        int s = socket(AF_CAN, c[i].type, c[i].proto); char n[40]; snprintf(n, 40, "type%d.proto%d", c[i].type, c[i].proto);
        out(n, "%s", s >= 0 ? "ok" : E(s)); if (s >= 0) close(s);
    }
    int p[2]; out("socketpair", "%s", E(socketpair(AF_CAN, SOCK_RAW, 1, p)));
    int s = socket(AF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW);
    out("flags", "cloexec %d nonblock %d", fcntl(s, F_GETFD) & FD_CLOEXEC, !!(fcntl(s, F_GETFL) & O_NONBLOCK));
    struct stat st; fstat(s, &st); out("fstat", "%o", st.st_mode & S_IFMT);
    int v; socklen_t l;
    static const struct { int n; const char *t; } o[] = {{SO_DOMAIN, "DOMAIN"}, {SO_TYPE, "TYPE"}, {SO_PROTOCOL, "PROTOCOL"}, {SO_ACCEPTCONN, "ACCEPTCONN"}, {SO_ERROR, "ERROR"},
        {SO_RXQ_OVFL, "RXQ_OVFL"}, {SO_TIMESTAMP, "TIMESTAMP"}, {SO_RCVBUF, "RCVBUF"}, {SO_SNDBUF, "SNDBUF"}, {SO_RCVLOWAT, "RCVLOWAT"}, {SO_PRIORITY, "PRIORITY"}, {SO_REUSEADDR, "REUSEADDR"}, {SO_PEERCRED, "PEERCRED"}, {SO_PASSCRED, "PASSCRED"}};
    for (unsigned i = 0; i < sizeof o / sizeof *o; i++) { v = -1; l = sizeof v; int r = getsockopt(s, SOL_SOCKET, o[i].n, &v, &l); if (r < 0) out(o[i].t, "%s", E(r)); else out(o[i].t, "%d len %d", o[i].n == SO_PEERCRED ? 0 : v, (int)l); }
    struct sockaddr_can a; memset(&a, 0xff, sizeof a); l = sizeof a;
    int r = getsockname(s, (void *)&a, &l); out("getsockname.unbound", "%s len %d family %d index %d", E(r), (int)l, a.can_family, a.can_ifindex);
    l = 4; r = getsockname(s, (void *)&a, &l); out("getsockname.short", "%s len %d", E(r), (int)l);
    l = sizeof a; out("getpeername", "%s", E(getpeername(s, (void *)&a, &l)));
    out("listen", "%s", E(listen(s, 1))); out("accept", "%s", E(accept(s, NULL, NULL))); out("shutdown", "%s", E(shutdown(s, SHUT_RDWR)));
    a = addr_of(index0()); out("connect", "%s", E(connect(s, (void *)&a, sizeof a)));
}

static void s_bind(void)
{
    struct sockaddr_can a = addr_of(index0()), b; socklen_t l;
    for (int n = 0; n <= 24; n += n < 7 ? 7 : 1) { if (n > 9 && n < 24) continue; int s = raw(); char t[20]; snprintf(t, 20, "len%d", n); out(t, "%s", E(bind(s, (void *)&a, n))); close(s); }
    int s = raw(); a.can_family = AF_INET; out("family", "%s", E(bind(s, (void *)&a, sizeof a)));
    a = addr_of(99999); out("unknown", "%s", E(bind(s, (void *)&a, sizeof a)));
    a = addr_of(-1); out("negative", "%s", E(bind(s, (void *)&a, sizeof a)));
    a = addr_of(1); out("lo", "%s", E(bind(s, (void *)&a, sizeof a)));
    a = addr_of(0); out("any", "%s", E(bind(s, (void *)&a, sizeof a)));
    a = addr_of(index0()); out("again", "%s", E(bind(s, (void *)&a, sizeof a))); out("same", "%s", E(bind(s, (void *)&a, sizeof a)));
    a = addr_of(index1()); out("other", "%s", E(bind(s, (void *)&a, sizeof a)));
    l = sizeof b; memset(&b, 0xff, sizeof b); int r = getsockname(s, (void *)&b, &l); out("name", "%s len %d family %d is_if1 %d", E(r), (int)l, b.can_family, b.can_ifindex == index1());
    int w = raw_on(index0()), w1 = raw_on(index1()); put(w, 0x100, 1, 1); put(w1, 0x101, 1, 1); ms(100); out("hears_only_other", "%d", drain(s, 100));
}

static void s_options(void)
{
    int s = raw_on(index0()), v; socklen_t l; char n[64];
    static const struct { int n; const char *t; } o[] = {{CAN_RAW_LOOPBACK, "LOOPBACK"}, {CAN_RAW_RECV_OWN_MSGS, "RECV_OWN"}, {CAN_RAW_FD_FRAMES, "FD"}, {CAN_RAW_JOIN_FILTERS, "JOIN"}, {CAN_RAW_ERR_FILTER, "ERR"}};
    for (unsigned i = 0; i < 5; i++) {
        v = -1; l = sizeof v; int r = getsockopt(s, SOL_CAN_RAW, o[i].n, &v, &l); snprintf(n, 64, "%s.default", o[i].t); out(n, "%s %d len %d", E(r), v, (int)l);
        v = 0x7fffffff; l = 1; r = getsockopt(s, SOL_CAN_RAW, o[i].n, &v, &l); snprintf(n, 64, "%s.get1", o[i].t); out(n, "%s len %d", E(r), (int)l);
        char big[16]; l = 16; r = getsockopt(s, SOL_CAN_RAW, o[i].n, big, &l); snprintf(n, 64, "%s.get16", o[i].t); out(n, "%s len %d", E(r), (int)l);
        v = 1; snprintf(n, 64, "%s.set1", o[i].t); out(n, "%s", E(setsockopt(s, SOL_CAN_RAW, o[i].n, &v, 1)));
        snprintf(n, 64, "%s.set8", o[i].t); long long w = 1; out(n, "%s", E(setsockopt(s, SOL_CAN_RAW, o[i].n, &w, 8)));
        snprintf(n, 64, "%s.set.NULL", o[i].t); out(n, "%s", E(setsockopt(s, SOL_CAN_RAW, o[i].n, NULL, 4)));
        v = 5; r = setsockopt(s, SOL_CAN_RAW, o[i].n, &v, sizeof v); int g = -1; l = sizeof g; getsockopt(s, SOL_CAN_RAW, o[i].n, &g, &l); snprintf(n, 64, "%s.set5", o[i].t); out(n, "%s then %d", E(r), g);
    }
    v = -1; l = 4; set(s, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, -1); getsockopt(s, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &v, &l); out("ERR.all", "%x", v);
    v = 1; out("XL.set", "%s", E(setsockopt(s, SOL_CAN_RAW, 7, &v, sizeof v)));
    out("unknown.set", "%s", E(setsockopt(s, SOL_CAN_RAW, 99, &v, sizeof v))); l = 4; out("unknown.get", "%s", E(getsockopt(s, SOL_CAN_RAW, 99, &v, &l)));
    out("level100.set", "%s", E(setsockopt(s, SOL_CAN_BASE, 1, &v, sizeof v))); l = 4; out("level100.get", "%s", E(getsockopt(s, SOL_CAN_BASE, 1, &v, &l)));
    l = 4; out("leveltcp.get", "%s", E(getsockopt(s, 6, 1, &v, &l)));
    l = -1; out("get.negative", "%s", E(getsockopt(s, SOL_CAN_RAW, CAN_RAW_LOOPBACK, &v, &l)));
    close(s); s = raw_on(index0());
    struct can_filter f[600]; memset(f, 0, sizeof f); f[0].can_id = 0x123 | CAN_INV_FILTER; f[0].can_mask = 0xffffffff;
    l = sizeof f; int r = getsockopt(s, SOL_CAN_RAW, CAN_RAW_FILTER, f, &l); out("FILTER.default", "%s len %d id %x mask %x", E(r), (int)l, f[0].can_id, f[0].can_mask);
    f[0].can_id = 0x123 | CAN_INV_FILTER; f[0].can_mask = 0xffffffff;
    static const int sizes[] = {0, 4, 8, 12, 16, 4096, 4104};
    for (unsigned i = 0; i < 7; i++) { snprintf(n, 64, "FILTER.set%d", sizes[i]); out(n, "%s", E(setsockopt(s, SOL_CAN_RAW, CAN_RAW_FILTER, f, sizes[i]))); struct can_filter g[600]; l = sizeof g; r = getsockopt(s, SOL_CAN_RAW, CAN_RAW_FILTER, g, &l); snprintf(n, 64, "FILTER.get%d", sizes[i]); out(n, "%s len %d", E(r), (int)l); }
    setsockopt(s, SOL_CAN_RAW, CAN_RAW_FILTER, f, 16); l = 8; r = getsockopt(s, SOL_CAN_RAW, CAN_RAW_FILTER, f, &l); out("FILTER.ERANGE", "%s len %d", E(r), (int)l);
    setsockopt(s, SOL_CAN_RAW, CAN_RAW_FILTER, f, 8); l = 8; getsockopt(s, SOL_CAN_RAW, CAN_RAW_FILTER, f, &l); out("FILTER.kept", "%x %x", f[0].can_id, f[0].can_mask);
    static const int bufs[] = {0, 100, 1000, 4096, 100000};
    for (unsigned i = 0; i < 5; i++) { set(s, SOL_SOCKET, SO_RCVBUF, bufs[i]); l = 4; getsockopt(s, SOL_SOCKET, SO_RCVBUF, &v, &l); snprintf(n, 64, "RCVBUF%d", bufs[i]); out(n, "%d", v); set(s, SOL_SOCKET, SO_SNDBUF, bufs[i]); l = 4; getsockopt(s, SOL_SOCKET, SO_SNDBUF, &v, &l); snprintf(n, 64, "SNDBUF%d", bufs[i]); out(n, "%d", v); }
    set(s, SOL_SOCKET, SO_TIMESTAMP, 1); l = 4; getsockopt(s, SOL_SOCKET, SO_TIMESTAMP, &v, &l); int w; getsockopt(s, SOL_SOCKET, SO_TIMESTAMPNS, &w, &l); out("TIMESTAMP", "%d ns %d", v, w);
    set(s, SOL_SOCKET, SO_TIMESTAMPNS, 1); getsockopt(s, SOL_SOCKET, SO_TIMESTAMP, &v, &l); getsockopt(s, SOL_SOCKET, SO_TIMESTAMPNS, &w, &l); out("TIMESTAMPNS", "%d ns %d", v, w);
    r = set(s, SOL_SOCKET, SO_TIMESTAMPING, SOF_TIMESTAMPING_RX_SOFTWARE | SOF_TIMESTAMPING_SOFTWARE); getsockopt(s, SOL_SOCKET, SO_TIMESTAMPING, &v, &l); out("TIMESTAMPING", "%s %x", E(r), v);
    r = set(s, SOL_SOCKET, SO_TIMESTAMPING, 1 << 30); out("TIMESTAMPING.bad", "%s", E(r));
    r = setsockopt(s, SOL_SOCKET, SO_BINDTODEVICE, if0, strlen(if0) + 1); out("BINDTODEVICE", "%s", E(r));
    struct sock_filter code[] = {{BPF_RET | BPF_K, 0, 0, 0xffffffff}}; struct sock_fprog prog = {1, code};
    out("ATTACH_FILTER", "%s", E(setsockopt(s, SOL_SOCKET, SO_ATTACH_FILTER, &prog, sizeof prog)));
    out("PRIORITY", "%s", E(set(s, SOL_SOCKET, SO_PRIORITY, 3))); out("BROADCAST", "%s", E(set(s, SOL_SOCKET, SO_BROADCAST, 1)));
}

static void s_ioctl(void)
{
    int s = raw_on(index0()), t = socket(AF_INET, SOCK_DGRAM, 0), v = -1;
    for (int k = 0; k < 2; k++) {
        int d = k ? t : s; char n[40]; struct ifreq q;
#define Q(name, req, show) do { memset(&q, 0, sizeof q); strcpy(q.ifr_name, if0); int r = ioctl(d, req, &q); snprintf(n, 40, "%s.%s", k ? "inet" : "can", name); if (r < 0) out(n, "%s", E(r)); else out(n, "%s %d", E(r), show); } while (0)
        Q("INDEX", SIOCGIFINDEX, q.ifr_ifindex == index0()); Q("MTU", SIOCGIFMTU, q.ifr_mtu); Q("FLAGS", SIOCGIFFLAGS, q.ifr_flags & (IFF_UP | IFF_NOARP | IFF_RUNNING | IFF_LOOPBACK | IFF_BROADCAST));
        Q("HWADDR", SIOCGIFHWADDR, q.ifr_hwaddr.sa_family); Q("TXQLEN", SIOCGIFTXQLEN, q.ifr_qlen >= 0); Q("ADDR", SIOCGIFADDR, 0); Q("METRIC", SIOCGIFMETRIC, q.ifr_metric); Q("MAP", SIOCGIFMAP, 0); Q("BRDADDR", SIOCGIFBRDADDR, 0);
        memset(&q, 0, sizeof q); strcpy(q.ifr_name, "nosuch0"); int r = ioctl(d, SIOCGIFINDEX, &q); snprintf(n, 40, "%s.unknown", k ? "inet" : "can"); out(n, "%s", E(r));
        memset(&q, 0, sizeof q); q.ifr_ifindex = index0(); r = ioctl(d, SIOCGIFNAME, &q); snprintf(n, 40, "%s.NAME", k ? "inet" : "can"); out(n, "%s %s", E(r), q.ifr_name);
        memset(&q, 0, sizeof q); q.ifr_ifindex = 88888; r = ioctl(d, SIOCGIFNAME, &q); snprintf(n, 40, "%s.NAME.unknown", k ? "inet" : "can"); out(n, "%s", E(r));
    }
    out("FIONREAD", "%s", E(ioctl(s, FIONREAD, &v))); out("OUTQ", "%s", E(ioctl(s, SIOCOUTQ, &v))); int one = 1; int fr = ioctl(s, FIONBIO, &one); out("FIONBIO", "%s %d", E(fr), !!(fcntl(s, F_GETFL) & O_NONBLOCK));
    struct timeval tv; out("GSTAMP.none", "%s", E(ioctl(s, SIOCGSTAMP, &tv)));
    char nm[IF_NAMESIZE] = ""; out("indextoname", "%s", if_indextoname(index0(), nm) ? nm : "NULL"); out("nametoindex.unknown", "%d %s", if_nametoindex("nosuch0"), E(-1)); out("indextoname.unknown", "%s %s", if_indextoname(88888, nm) ? nm : "NULL", E(-1));
    int found = 0; struct if_nameindex *x = if_nameindex(); for (int i = 0; x && x[i].if_index; i++) found += !strcmp(x[i].if_name, if0); if_freenameindex(x); out("nameindex", "%d", found);
    struct ifaddrs *fa; found = 0; int fam = -1; if (getifaddrs(&fa) == 0) { for (struct ifaddrs *p = fa; p; p = p->ifa_next) if (!strcmp(p->ifa_name, if0)) { found++; fam = p->ifa_addr ? p->ifa_addr->sa_family : -2; } freeifaddrs(fa); } out("getifaddrs", "%d family %d", found, fam);
    char path[64]; snprintf(path, 64, "/sys/class/net/%s/type", if0); FILE *h = fopen(path, "r"); char line[64] = "none"; if (h) { if (!fgets(line, 64, h)) line[0] = 0; line[strcspn(line, "\n")] = 0; } out("sysfs", "%s", line);
    out("procnetcan", "%s", access("/proc/net/can/rcvlist_all", R_OK) ? "none" : "there");
}

static void s_write(void)
{
    int s = raw_on(index0()), r = raw_on(index0()), u = raw(), any = raw_on(0); char b[2100]; memset(b, 0, sizeof b); char n[40];
    static const int sz[] = {0, 1, 8, 15, 16, 17, 24, 71, 72, 73, 2060};
    struct can_frame f = frame(0x123, 2, 1); memcpy(b, &f, sizeof f);
    for (unsigned i = 0; i < 11; i++) { snprintf(n, 40, "size%d", sz[i]); out(n, "%s", E(write(s, b, sz[i]))); }
    set(s, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, 1); out("fd.on.72", "%s", E(write(s, b, 72))); out("fd.on.16", "%s", E(write(s, b, 16))); out("fd.on.40", "%s", E(write(s, b, 40)));
    struct canfd_frame g; memset(&g, 0, sizeof g); g.can_id = 0x124; g.len = 65; out("fd.len65", "%s", E(write(s, &g, 72))); g.len = 64; out("fd.len64", "%s", E(write(s, &g, 72))); g.len = 9; out("fd.len9", "%s", E(write(s, &g, 72)));
    f.can_dlc = 9; out("dlc9", "%s", E(write(s, &f, 16))); f.can_dlc = 8; out("dlc8", "%s", E(write(s, &f, 16))); f.can_dlc = 255; out("dlc255", "%s", E(write(s, &f, 16))); f.can_dlc = 2;
    f.can_id = 0xfff; out("sff.too.big", "%s", E(write(s, &f, 16))); f.can_id = 0x123 | CAN_RTR_FLAG; out("rtr", "%s", E(write(s, &f, 16))); f.can_id = CAN_ERR_FLAG | 4; out("err", "%s", E(write(s, &f, 16))); f.can_id = 0x123;
    ms(100); out("heard", "%d", drain(r, 150)); drain(any, 50);
    out("unbound", "%s", E(write(u, &f, 16))); out("any.noaddr", "%s", E(write(any, &f, 16)));
    struct sockaddr_can a = addr_of(index0()); out("sendto.unbound", "%s", E(sendto(u, &f, 16, 0, (void *)&a, sizeof a))); out("sendto.len7", "%s", E(sendto(u, &f, 16, 0, (void *)&a, 7))); out("sendto.len8", "%s", E(sendto(u, &f, 16, 0, (void *)&a, 8)));
    a.can_family = 2; out("sendto.family", "%s", E(sendto(u, &f, 16, 0, (void *)&a, sizeof a))); a = addr_of(0); out("sendto.index0", "%s", E(sendto(s, &f, 16, 0, (void *)&a, sizeof a)));
    a = addr_of(77777); out("sendto.unknown", "%s", E(sendto(s, &f, 16, 0, (void *)&a, sizeof a))); a = addr_of(1); out("sendto.lo", "%s", E(sendto(s, &f, 16, 0, (void *)&a, sizeof a))); a = addr_of(-5); out("sendto.negative", "%s", E(sendto(s, &f, 16, 0, (void *)&a, sizeof a)));
    a = addr_of(index1()); int o = raw_on(index1()); out("sendto.other", "%s", E(sendto(s, &f, 16, 0, (void *)&a, sizeof a))); ms(50); out("sendto.other.heard", "%d", drain(o, 150));
    struct iovec v[3] = {{&f, 4}, {(char *)&f + 4, 4}, {(char *)&f + 8, 8}}; out("writev", "%s", E(writev(s, v, 3)));
    struct msghdr m = {.msg_iov = v, .msg_iovlen = 3}; out("sendmsg", "%s", E(sendmsg(s, &m, 0))); out("sendmsg.OOB", "%s", E(sendmsg(s, &m, MSG_OOB)));
    struct mmsghdr mm[3]; memset(mm, 0, sizeof mm); for (int i = 0; i < 3; i++) { mm[i].msg_hdr.msg_iov = v; mm[i].msg_hdr.msg_iovlen = 3; } { int q = sendmmsg(s, mm, 3, 0); out("sendmmsg", "%s len %d", E(q), mm[2].msg_len); }
    mm[1].msg_hdr.msg_iovlen = 1; out("sendmmsg.second.bad", "%s", E(sendmmsg(s, mm, 3, 0)));
    struct { struct cmsghdr h; int d; } c = {{CMSG_LEN(4), SOL_SOCKET, 12345}, 0}; m.msg_control = &c; m.msg_controllen = sizeof c; out("sendmsg.badcmsg", "%s", E(sendmsg(s, &m, 0)));
    struct { struct cmsghdr h; unsigned d; } ct = {{CMSG_LEN(4), SOL_SOCKET, SO_TIMESTAMPING}, SOF_TIMESTAMPING_TX_SOFTWARE}; m.msg_control = &ct; m.msg_controllen = sizeof ct; out("sendmsg.tscmsg", "%s", E(sendmsg(s, &m, 0)));
    out("pwrite", "%s", E(pwrite(s, &f, 16, 0))); out("pwritev2", "%s", E(pwritev2(s, v, 3, -1, 0)));
    ms(100); drain(r, 100);
    int fd = syscall(SYS_memfd_create, "x", 0); long wr = write(fd, &f, 16); lseek(fd, 0, SEEK_SET); wr = sendfile(s, fd, NULL, 16); out("sendfile", "%s heard %d", E(wr), drain(r, 150));
    int p[2]; if (pipe(p) == 0) { if (write(p[1], &f, 16)) {} wr = splice(p[0], NULL, s, NULL, 16, 0); out("splice", "%s heard %d", E(wr), drain(r, 150)); }
    wr = syscall(SYS_write, s, &f, 16); out("syscall.write", "%s heard %d", E(wr), drain(r, 150));
    FILE *h = fdopen(dup(s), "w"); setvbuf(h, NULL, _IONBF, 0); wr = fwrite(&f, 1, 16, h); fflush(h); out("fwrite", "%ld heard %d", wr, drain(r, 150));
}

static void cmsgs(const char *name, int s, size_t room)
{
    struct can_frame f; char c[512]; struct sockaddr_can a; memset(&a, 0xee, sizeof a); struct iovec v = {&f, sizeof f}; struct msghdr m = {.msg_iov = &v, .msg_iovlen = 1, .msg_control = c, .msg_controllen = room, .msg_name = &a, .msg_namelen = sizeof a};
    if (!ready(s, 500)) { out(name, "nothing"); return; }
    long r = recvmsg(s, &m, 0); char t[400]; int at = snprintf(t, sizeof t, "%s flags %x name %d ctl %d:", E(r), m.msg_flags & ~MSG_CMSG_CLOEXEC, (int)m.msg_namelen, (int)m.msg_controllen);
    for (struct cmsghdr *h = CMSG_FIRSTHDR(&m); h; h = CMSG_NXTHDR(&m, h)) {
        struct timespec *x = (void *)CMSG_DATA(h); struct timespec nw; clock_gettime(CLOCK_REALTIME, &nw);
        at += snprintf(t + at, sizeof t - at, " type%d len%d", h->cmsg_type, (int)h->cmsg_len);
        if (h->cmsg_type == SO_TIMESTAMPING) at += snprintf(t + at, sizeof t - at, "(%d%d%d)", !!x[0].tv_sec, !!x[1].tv_sec, !!x[2].tv_sec);
        else if (h->cmsg_type != SO_RXQ_OVFL) at += snprintf(t + at, sizeof t - at, "(%s)", labs(nw.tv_sec - x[0].tv_sec) < 3 ? "now" : "far");
    }
    out(name, "%s", t);
}

static void s_read(void)
{
    int w = raw_on(index0()), s = raw_on(index0()); char b[2048]; struct can_frame f; long r; socklen_t l; struct sockaddr_can a; double t;
    out("empty.dontwait", "%s", E(recv(s, b, 16, MSG_DONTWAIT)));
    fcntl(s, F_SETFL, O_NONBLOCK); out("empty.nonblock", "%s", E(read(s, b, 16))); fcntl(s, F_SETFL, 0);
    struct timeval tv = {0, 100000}; setsockopt(s, SOL_SOCKET, SO_RCVTIMEO, &tv, sizeof tv); t = now(); r = read(s, b, 16); t = now() - t; out("rcvtimeo100ms", "%s %s", E(r), t > 0.09 && t < 0.4 ? "in time" : "NOT in time");
    tv.tv_usec = 500; setsockopt(s, SOL_SOCKET, SO_RCVTIMEO, &tv, sizeof tv); t = now(); alarm(3); r = read(s, b, 16); t = now() - t; alarm(20); out("rcvtimeo500us", "%s %s", E(r), t < 0.4 ? "in time" : "NOT in time");
    tv.tv_usec = 0; setsockopt(s, SOL_SOCKET, SO_RCVTIMEO, &tv, sizeof tv);
    put(w, 0x111, 4, 1); ready(s, 1000); out("errqueue.full", "%s", E(recv(s, b, 16, MSG_ERRQUEUE | MSG_DONTWAIT))); out("peek", "%s", E(recv(s, b, 16, MSG_PEEK | MSG_DONTWAIT))); out("peek.again", "%s", E(recv(s, b, 16, MSG_PEEK | MSG_DONTWAIT))); out("then.read", "%s", E(recv(s, b, 16, MSG_DONTWAIT))); out("then.none", "%s", E(recv(s, b, 16, MSG_DONTWAIT)));
    put(w, 0x111, 4, 1); ready(s, 1000); out("read8", "%s", E(read(s, b, 8))); out("read8.rest", "%s", E(recv(s, b, 16, MSG_DONTWAIT)));
    put(w, 0x111, 4, 1); ready(s, 1000); out("read0", "%s", E(read(s, b, 0))); out("read0.rest", "%s", E(recv(s, b, 16, MSG_DONTWAIT)));
    drain(s, 50); put(w, 0x111, 4, 1); ready(s, 1000); out("recv0", "%s", E(recv(s, b, 0, 0))); out("recv0.rest", "%s", E(recv(s, b, 16, MSG_DONTWAIT)));
    drain(s, 50); put(w, 0x111, 4, 1); ready(s, 1000); out("trunc", "%s", E(recv(s, b, 8, MSG_TRUNC)));
    put(w, 0x111, 4, 1); ready(s, 1000); out("read2000", "%s", E(read(s, b, 2000)));
    put(w, 0x111, 4, 1); ready(s, 1000); out("waitall", "%s", E(recv(s, b, 2000, MSG_WAITALL)));
    put(w, 0x111, 4, 1); ready(s, 1000); memset(&a, 0xee, sizeof a); l = sizeof a; r = recvfrom(s, &f, 16, 0, (void *)&a, &l); out("recvfrom", "%s len %d family %d ours %d", E(r), (int)l, a.can_family, a.can_ifindex == index0());
    put(w, 0x111, 4, 1); ready(s, 1000); l = 4; r = recvfrom(s, &f, 16, 0, (void *)&a, &l); out("recvfrom.short", "%s len %d", E(r), (int)l);
    struct iovec v[2] = {{b, 5}, {b + 5, 100}}; put(w, 0x111, 4, 1); ready(s, 1000); out("readv", "%s", E(readv(s, v, 2)));
    put(w, 0x111, 4, 1); ready(s, 1000); out("preadv2", "%s", E(preadv2(s, v, 2, -1, 0))); drain(s, 50); out("pread", "%s", E(pread(s, b, 16, 0)));
    struct timeval g; put(w, 0x111, 4, 1); ready(s, 1000); r = read(s, b, 16); int q = ioctl(s, SIOCGSTAMP, &g); out("GSTAMP.first", "%s %s", E(q), q < 0 ? "" : labs(time(NULL) - g.tv_sec) < 3 ? "now" : "far");
    put(w, 0x111, 4, 1); ready(s, 1000); r = read(s, b, 16); q = ioctl(s, SIOCGSTAMP, &g); out("GSTAMP.second", "%s %s", E(q), q < 0 ? "" : labs(time(NULL) - g.tv_sec) < 3 ? "now" : "far");
    struct mmsghdr mm[4]; char bb[4][16]; struct iovec vv[4]; memset(mm, 0, sizeof mm); for (int i = 0; i < 4; i++) { vv[i] = (struct iovec){bb[i], 16}; mm[i].msg_hdr.msg_iov = &vv[i]; mm[i].msg_hdr.msg_iovlen = 1; }
    for (int i = 0; i < 3; i++) put(w, 0x111, 4, i); ms(150); out("recvmmsg.dontwait", "%s", E(recvmmsg(s, mm, 4, MSG_DONTWAIT, NULL)));
    for (int i = 0; i < 3; i++) put(w, 0x111, 4, i); ms(150); out("recvmmsg.waitforone", "%s", E(recvmmsg(s, mm, 4, MSG_WAITFORONE, NULL)));
    struct timespec ts = {0, 200000000}; for (int i = 0; i < 3; i++) put(w, 0x111, 4, i); ms(150); t = now(); pid_t c = fork(); if (!c) { ms(600); put(w, 0x112, 1, 1); _exit(0); } r = recvmmsg(s, mm, 4, 0, &ts); t = now() - t; alarm(20); out("recvmmsg.timeout", "%s", E(r)); waitpid(c, NULL, 0); drain(s, 200);
    // flags: from another socket of this machine, from itself
    cmsgs("none", s, 512); put(w, 0x111, 4, 1); cmsgs("plain", s, 512);
    set(w, SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, 1); drain(w, 50); put(w, 0x111, 4, 1); cmsgs("own", w, 512); drain(s, 100);
    set(s, SOL_SOCKET, SO_TIMESTAMP, 1); put(w, 0x111, 4, 1); cmsgs("TIMESTAMP", s, 512); put(w, 0x111, 4, 1); cmsgs("TIMESTAMP.room16", s, 16); put(w, 0x111, 4, 1); cmsgs("TIMESTAMP.room20", s, 20);
    set(s, SOL_SOCKET, SO_TIMESTAMPNS, 1); put(w, 0x111, 4, 1); cmsgs("TIMESTAMPNS", s, 512); set(s, SOL_SOCKET, SO_RXQ_OVFL, 1); put(w, 0x111, 4, 1); cmsgs("TIMESTAMPNS.OVFL", s, 512);
    set(s, SOL_SOCKET, SO_TIMESTAMPING, SOF_TIMESTAMPING_RX_SOFTWARE | SOF_TIMESTAMPING_SOFTWARE); put(w, 0x111, 4, 1); cmsgs("NS+TIMESTAMPING", s, 512);
    set(s, SOL_SOCKET, SO_TIMESTAMPNS, 0); put(w, 0x111, 4, 1); cmsgs("TIMESTAMPING.sw", s, 512);
    set(s, SOL_SOCKET, SO_TIMESTAMPING, SOF_TIMESTAMPING_RX_HARDWARE | SOF_TIMESTAMPING_RAW_HARDWARE); put(w, 0x111, 4, 1); cmsgs("TIMESTAMPING.hw", s, 512);
    set(s, SOL_SOCKET, SO_TIMESTAMPING, SOF_TIMESTAMPING_SOFTWARE); put(w, 0x111, 4, 1); cmsgs("TIMESTAMPING.report.only", s, 512);
    set(s, SOL_SOCKET, SO_TIMESTAMPING, 0);
    // transmit time stamps come by the error queue
    drain(w, 50); set(w, SOL_SOCKET, SO_TIMESTAMPING, SOF_TIMESTAMPING_TX_SOFTWARE | SOF_TIMESTAMPING_SOFTWARE | SOF_TIMESTAMPING_OPT_TSONLY); put(w, 0x119, 1, 1); ms(100); drain(s, 50);
    struct pollfd p = {w, POLLIN | POLLERR, 0}; poll(&p, 1, 200); char ec[256]; struct iovec ev = {b, 100}; struct msghdr em = {.msg_iov = &ev, .msg_iovlen = 1, .msg_control = ec, .msg_controllen = 256}; r = recvmsg(w, &em, MSG_ERRQUEUE | MSG_DONTWAIT); out("tx.timestamp", "revents %x %s ctl %d", p.revents, E(r), r < 0 ? 0 : (int)em.msg_controllen);
    set(w, SOL_SOCKET, SO_TIMESTAMPING, 0); set(w, SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, 0); drain(w, 50); drain(s, 50);
    // bypasses
    put(w, 0x111, 4, 1); ready(s, 1000); out("syscall.read", "%s", E(syscall(SYS_read, s, b, 100))); drain(s, 50);
    put(w, 0x111, 4, 1); ready(s, 1000); FILE *h = fdopen(dup(s), "r"); setvbuf(h, NULL, _IONBF, 0); fcntl(s, F_SETFL, O_NONBLOCK); out("fread", "%d", (int)fread(b, 1, 16, h)); fcntl(s, F_SETFL, 0); drain(s, 50);
}

static int tp(unsigned rx, unsigned tx, int flags, int *err);
static void s_efault_write(void) { int s = raw_on(index0()); out("write", "%s", E(write(s, NULL, 16))); }
static void s_efault_read(void) { int s = raw_on(index0()), w = raw_on(index0()); put(w, 0x111, 4, 1); ready(s, 1000); out("read", "%s", E(recv(s, (void *)8, 16, MSG_DONTWAIT))); }
static void s_efault_opt(void) { int s = raw_on(index0()); socklen_t l = 4; out("getsockopt", "%s", E(getsockopt(s, SOL_CAN_RAW, CAN_RAW_LOOPBACK, NULL, &l))); }
static void s_efault_ioctl(void) { int s = raw_on(index0()); out("ioctl", "%s", E(ioctl(s, SIOCGIFINDEX, (void *)8))); }
static void s_errqueue(void) { int s = raw_on(index0()); char b[16]; out("empty", "%s", E(recv(s, b, 16, MSG_ERRQUEUE))); }
static void s_errqueue2(void) { int s = tp(0x701, 0x702, 0, NULL); char b[16]; out("isotp", "%s", E(recv(s, b, 16, MSG_ERRQUEUE))); }
static void s_overflow(void)
{
    int w = raw_on(index0()), s = raw_on(index0()), n, got = 0; unsigned drops = 0; set(s, SOL_SOCKET, SO_RXQ_OVFL, 1); set(s, SOL_SOCKET, SO_RCVBUF, 4096);
    int acc = 0; for (n = 0; n < 6000; n++) { for (int k = 0; k < 200; k++) { if (put(w, 0x100, 8, n) == 16) { acc++; break; } ms(10); } }
    ms(1500); put(w, 0x7ff, 0, 0);
    ms(200); struct can_frame f; char c[256];
    for (;;) { struct iovec v = {&f, 16}; struct msghdr m = {.msg_iov = &v, .msg_iovlen = 1, .msg_control = c, .msg_controllen = sizeof c}; if (!ready(s, 200) || recvmsg(s, &m, MSG_DONTWAIT) < 0) break; got++; for (struct cmsghdr *h = CMSG_FIRSTHDR(&m); h; h = CMSG_NXTHDR(&m, h)) if (h->cmsg_type == SO_RXQ_OVFL) memcpy(&drops, CMSG_DATA(h), 4); }
    put(w, 0x7fe, 0, 0); if (ready(s, 500)) { struct iovec v = {&f, 16}; struct msghdr m = {.msg_iov = &v, .msg_iovlen = 1, .msg_control = c, .msg_controllen = sizeof c}; recvmsg(s, &m, 0); got++; for (struct cmsghdr *h = CMSG_FIRSTHDR(&m); h; h = CMSG_NXTHDR(&m, h)) if (h->cmsg_type == SO_RXQ_OVFL) memcpy(&drops, CMSG_DATA(h), 4); }
    out("accepted", "%d", acc); out("got.plus.drops", "%s", got + (int)drops == 6002 ? "all" : "not all"); out("numbers", "got %d drops %u", got, drops);
}

static int matrix(int loop, int own, int fdself, int fdother)
{
    int s = raw_on(index0()), t = raw_on(index0()); set(s, SOL_CAN_RAW, CAN_RAW_LOOPBACK, loop); set(s, SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, own); set(s, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, fdself); set(t, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, fdother);
    struct canfd_frame g; memset(&g, 0, sizeof g); g.can_id = 0x123; g.len = 12; put(s, 0x123, 1, 1); if (write(s, &g, 72) < 0) {} ms(60); int a = drain(s, 100), b = drain(t, 100); close(s); close(t); return a * 10 + b;
}
static void s_loop(void)
{
    for (int i = 0; i < 16; i++) { char n[40]; snprintf(n, 40, "loop%d.own%d.fdself%d.fdother%d", i & 1, i >> 1 & 1, i >> 2 & 1, i >> 3 & 1); out(n, "%02d", matrix(i & 1, i >> 1 & 1, i >> 2 & 1, i >> 3 & 1)); }
    // filters with a matrix of frames
    static const unsigned ids[] = {0x123, 0x123 | CAN_RTR_FLAG, 0x123 | CAN_EFF_FLAG, 0x123 | CAN_EFF_FLAG | CAN_RTR_FLAG, 0x124, 0x1ABCDE | CAN_EFF_FLAG};
    static const struct { struct can_filter f[3]; int n, join; } c[] = {
        {{{0x123, 0x7ff}}, 1, 0}, {{{0x123, CAN_SFF_MASK | CAN_EFF_FLAG | CAN_RTR_FLAG}}, 1, 0}, {{{0x123 | CAN_EFF_FLAG, CAN_EFF_MASK | CAN_EFF_FLAG}}, 1, 0}, {{{0x123 | CAN_INV_FILTER, 0x7ff}}, 1, 0},
        {{{0x123 | CAN_INV_FILTER, 0xC00007ff}}, 1, 0}, {{{CAN_RTR_FLAG, CAN_RTR_FLAG}}, 1, 0}, {{{0, CAN_EFF_FLAG}}, 1, 0}, {{{CAN_EFF_FLAG, CAN_EFF_FLAG}}, 1, 0}, {{{0x123, 0x7ff}, {0x124, 0x7ff}}, 2, 0}, {{{0x123, 0x7ff}, {0x124, 0x7ff}}, 2, 1},
        {{{0x120, 0x7f0}, {0x123 | CAN_INV_FILTER, 0x7ff}}, 2, 1}, {{{0x123, 0x7ff}, {0x123, 0x7ff}}, 2, 0}, {{{0x123, 0x7ff}, {0x123, 0x7ff}}, 2, 1}, {{{0x123, 0xffffffff}}, 1, 0}, {{{0x123, 0x1fffffff}}, 1, 0}, {{{0xfff, 0xfff}}, 1, 0},
        {{{0x123, 0x7ff}, {CAN_INV_FILTER | 0x124, 0x7ff}, {0, 0}}, 3, 1}, {{{0, 0}}, 0, 0}, {{{CAN_INV_FILTER, 0}}, 1, 0}, {{{0x123, 0x7ff}, {0, CAN_ERR_FLAG}}, 2, 1}, {{{0, 0x20000000 | 0x1fffffff}}, 1, 0}, {{{0x123, CAN_EFF_MASK | CAN_EFF_FLAG | CAN_RTR_FLAG}}, 1, 0}};
    for (unsigned i = 0; i < sizeof c / sizeof *c; i++) {
        int s = raw_on(index0()), t = raw(); set(t, SOL_CAN_RAW, CAN_RAW_JOIN_FILTERS, c[i].join); setsockopt(t, SOL_CAN_RAW, CAN_RAW_FILTER, c[i].f, 8 * c[i].n); struct sockaddr_can a = addr_of(index0()); if (bind(t, (void *)&a, sizeof a)) {}
        for (int k = 0; k < 6; k++) put(s, ids[k], 0, 0);
        char h[64] = ""; struct can_frame f; ms(40); while (ready(t, 60) && recv(t, &f, 16, MSG_DONTWAIT) == 16) for (int k = 0; k < 6; k++) if (f.can_id == ids[k]) sprintf(h + strlen(h), "%d", k);
        char n[40]; snprintf(n, 40, "filter%u", i); out(n, "%s", h); close(s); close(t);
    }
    int s = raw_on(index0()), any = raw_on(0); put(s, 0x123, 1, 1); struct sockaddr_can a = addr_of(index1()); struct can_frame f = frame(0x124, 1, 1); sendto(s, &f, 16, 0, (void *)&a, sizeof a); ms(100); out("any.hears", "%d", drain(any, 100));
    set(any, SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, 1); a = addr_of(index0()); sendto(any, &f, 16, 0, (void *)&a, sizeof a); ms(50); out("any.own", "%d", drain(any, 100));
    // filters changed while frames wait: what waits stays
    int q = raw_on(index0()); put(s, 0x200, 1, 1); ms(100); setsockopt(q, SOL_CAN_RAW, CAN_RAW_FILTER, NULL, 0); out("filter.later", "%d", drain(q, 100)); put(s, 0x200, 1, 1); ms(50); out("filter.none", "%d", drain(q, 100));
}

static volatile int sigs; static void on_sig(int n) { (void)n; sigs++; }
static void s_poll(void)
{
    int w = raw_on(index0()), s = raw_on(index0()), u = raw(); char b[100]; const short all = POLLIN | POLLOUT | POLLPRI | POLLRDNORM | POLLRDBAND | POLLWRNORM | POLLWRBAND;
    struct pollfd p = {s, all, 0}; int pr = poll(&p, 1, 0); out("poll.empty", "%s %x", E(pr), p.revents); p.fd = u; pr = poll(&p, 1, 0); out("poll.unbound", "%s %x", E(pr), p.revents);
    put(w, 0x100, 1, 1); ms(100); p.fd = s; pr = poll(&p, 1, 0); out("poll.one", "%s %x", E(pr), p.revents); drain(s, 20);
    fd_set r, x; FD_ZERO(&r); FD_SET(s, &r); x = r; struct timeval tv = {0, 50000}; out("select.empty", "%s", E(select(s + 1, &r, NULL, NULL, &tv))); FD_SET(s, &r); put(w, 0x100, 1, 1); tv.tv_sec = 1; out("select.one", "%s", E(select(s + 1, &r, NULL, NULL, &tv))); drain(s, 20);
    int e = epoll_create1(0); struct epoll_event ev = {.events = EPOLLIN}, got; epoll_ctl(e, EPOLL_CTL_ADD, s, &ev); put(w, 0x100, 1, 1); ms(50); int n = epoll_wait(e, &got, 1, 500); out("lt", "%d %x", n, got.events); n = epoll_wait(e, &got, 1, 50); out("lt.again", "%d", n); drain(s, 20); out("lt.drained", "%d", epoll_wait(e, &got, 1, 50));
    ev.events = EPOLLIN | EPOLLET; epoll_ctl(e, EPOLL_CTL_MOD, s, &ev); put(w, 0x100, 1, 1); ms(50); n = epoll_wait(e, &got, 1, 500); out("et.first", "%d", n); out("et.same", "%d", epoll_wait(e, &got, 1, 100)); put(w, 0x101, 1, 1); ms(50); out("et.second.unread", "%d", epoll_wait(e, &got, 1, 300));
    drain(s, 20); int events = 0, reads = 0; for (int i = 0; i < 5; i++) { put(w, 0x102, 1, i); put(w, 0x103, 1, i); ms(30); if (epoll_wait(e, &got, 1, 300) > 0) { events++; if (recv(s, b, 16, MSG_DONTWAIT) == 16) reads++; } } out("et.one.read.per.event", "events %d reads %d", events, reads); drain(s, 20);
    ev.events = EPOLLIN | EPOLLONESHOT; epoll_ctl(e, EPOLL_CTL_MOD, s, &ev); put(w, 0x100, 1, 1); ms(50); n = epoll_wait(e, &got, 1, 300); put(w, 0x100, 1, 1); ms(50); int m = epoll_wait(e, &got, 1, 100); epoll_ctl(e, EPOLL_CTL_MOD, s, &ev); out("oneshot", "%d %d rearmed %d", n, m, epoll_wait(e, &got, 1, 100)); drain(s, 20);
    ev.events = EPOLLOUT; epoll_ctl(e, EPOLL_CTL_MOD, s, &ev); out("epollout", "%d", epoll_wait(e, &got, 1, 100)); ev.events = EPOLLOUT | EPOLLET | EPOLLIN; epoll_ctl(e, EPOLL_CTL_MOD, w, &ev); close(e);
    e = epoll_create1(0); ev.events = EPOLLOUT | EPOLLET; epoll_ctl(e, EPOLL_CTL_ADD, w, &ev); n = epoll_wait(e, &got, 1, 100); m = epoll_wait(e, &got, 1, 100); put(w, 0x100, 1, 1); ms(50); out("epollout.et", "%d %d after.write %d", n, m, epoll_wait(e, &got, 1, 200)); drain(s, 50);
    signal(SIGIO, on_sig); fcntl(s, F_SETOWN, getpid()); fcntl(s, F_SETFL, O_ASYNC | O_NONBLOCK); sigs = 0; put(w, 0x100, 1, 1); ms(100); out("sigio.first", "%d", sigs > 0); sigs = 0; put(w, 0x100, 1, 1); ms(100); out("sigio.second.unread", "%d", sigs > 0); drain(s, 20); sigs = 0; put(w, 0x100, 1, 1); ms(100); out("sigio.third.read", "%d", sigs > 0);
    fcntl(s, F_SETFL, 0); drain(s, 20); signal(SIGALRM, on_sig); struct sigaction sa = {.sa_handler = on_sig}; sigaction(SIGALRM, &sa, NULL); sigs = 0; struct itimerval it = {{0, 0}, {0, 100000}}; setitimer(ITIMER_REAL, &it, NULL); out("read.EINTR", "%s", E(read(s, b, 16)));
    sa.sa_flags = SA_RESTART; sigaction(SIGALRM, &sa, NULL); setitimer(ITIMER_REAL, &it, NULL); pid_t c = fork(); if (!c) { ms(400); put(w, 0x100, 1, 1); _exit(0); } out("read.RESTART", "%s", E(read(s, b, 16))); waitpid(c, NULL, 0);
}

static int one_sock; static int counted; static void *reader(void *a) { char b[16]; (void)a; for (int quiet = 0; counted < 2000 && quiet < 50; quiet++) if (ready(one_sock, 200)) { quiet = 0; if (recv(one_sock, b, 16, MSG_DONTWAIT) == 16) __atomic_fetch_add(&counted, 1, __ATOMIC_RELAXED); } return NULL; }
static void *closer(void *a) { ms(200); close(*(int *)a); return NULL; }
static void s_fds(char **argv)
{
    int w = raw_on(index0()), s = raw_on(index0()); char b[100];
    int d = dup(s); close(s); put(w, 0x100, 1, 1); out("dup", "%d", drain(d, 200)); int e = dup2(d, 150); close(d); put(w, 0x100, 1, 1); out("dup2", "%d", drain(e, 200)); int f = fcntl(e, F_DUPFD_CLOEXEC, 90); close(e); put(w, 0x100, 1, 1); out("dupfd", "%d", drain(f, 200));
    pid_t c = fork(); if (!c) { int n = drain(f, 300); _exit(n); } ms(50); put(w, 0x100, 1, 1); put(w, 0x101, 1, 1); int st; waitpid(c, &st, 0); out("fork.child.reads", "%d", WEXITSTATUS(st));
    c = fork(); if (!c) { close(f); close(w); _exit(0); } waitpid(c, &st, 0); put(w, 0x100, 1, 1); out("child.closed", "%d", drain(f, 200));
    c = fork(); if (!c) { int x = raw_on(index0()); _exit(put(x, 0x100, 1, 1) == 16 ? 7 : 8); } waitpid(c, &st, 0); out("child.opens", "%d heard %d", WEXITSTATUS(st), drain(f, 200));
    c = vfork(); if (!c) _exit(0); waitpid(c, &st, 0);
    fcntl(f, F_SETFD, 0); fcntl(w, F_SETFD, 0); c = fork(); if (!c) { char n[20]; snprintf(n, 20, "%d", w); execl(argv[0], argv[0], "--send", n, NULL); _exit(99); } waitpid(c, &st, 0); out("exec", "%d heard %d", WEXITSTATUS(st), drain(f, 200));
    fcntl(w, F_SETFD, FD_CLOEXEC); c = fork(); if (!c) { char n[20]; snprintf(n, 20, "%d", w); execl(argv[0], argv[0], "--send", n, NULL); _exit(99); } waitpid(c, &st, 0); out("exec.cloexec", "%d heard %d", WEXITSTATUS(st), drain(f, 200));
    int sp[2]; if (socketpair(AF_UNIX, SOCK_DGRAM, 0, sp)) {} c = fork(); if (!c) { close(f); char cb[CMSG_SPACE(4)]; char x; struct iovec v = {&x, 1}; struct msghdr m = {.msg_iov = &v, .msg_iovlen = 1, .msg_control = cb, .msg_controllen = sizeof cb}; recvmsg(sp[1], &m, 0); int r; memcpy(&r, CMSG_DATA(CMSG_FIRSTHDR(&m)), 4); _exit(drain(r, 300)); }
    { union { struct cmsghdr h; char c[CMSG_SPACE(4)]; } u; struct iovec v = {"x", 1}; struct msghdr m = {.msg_iov = &v, .msg_iovlen = 1, .msg_control = &u, .msg_controllen = sizeof u}; u.h.cmsg_level = SOL_SOCKET; u.h.cmsg_type = SCM_RIGHTS; u.h.cmsg_len = CMSG_LEN(4); memcpy(CMSG_DATA(&u.h), &f, 4); sendmsg(sp[0], &m, 0); } ms(50); put(w, 0x100, 1, 1); waitpid(c, &st, 0); out("scm_rights", "%d", WEXITSTATUS(st));
    one_sock = f; pthread_t t[4]; for (int i = 0; i < 4; i++) pthread_create(&t[i], NULL, reader, NULL); for (int i = 0; i < 2000; i++) { put(w, 0x100, 8, i); if (i % 20 == 0) ms(5); } for (int i = 0; i < 4; i++) pthread_join(t[i], NULL); out("threads.read", "%d", counted + drain(f, 100));
    int x = raw_on(index0()); pthread_t k; pthread_create(&k, NULL, closer, &x); ms(1); struct timeval tv = {1, 0}; setsockopt(x, SOL_SOCKET, SO_RCVTIMEO, &tv, sizeof tv); double t0 = now(); long r = read(x, b, 16); double took = now() - t0; out("close.while.reading", "%s %s", E(r), took > 0.9 ? "after the timeout" : "at the close"); pthread_join(k, NULL);
    out("closed", "%s", E(read(x, b, 16))); out("closed.write", "%s", E(write(x, b, 16)));
    struct { int n; } many = {0}; int socks[300]; for (int i = 0; i < 300; i++) { socks[i] = socket(AF_CAN, SOCK_RAW, CAN_RAW); struct sockaddr_can a = addr_of(index0()); if (socks[i] >= 0 && bind(socks[i], (void *)&a, sizeof a) == 0) many.n++; } put(w, 0x123, 1, 1); ms(300); int heard = 0; for (int i = 0; i < 300; i++) { if (recv(socks[i], b, 16, MSG_DONTWAIT) == 16) heard++; close(socks[i]); } out("300.sockets", "%d heard %d", many.n, heard);
}

struct bmsg { struct bcm_msg_head h; struct can_frame f[260]; };
static int bcm(int index) { int s = socket(AF_CAN, SOCK_DGRAM, CAN_BCM); struct sockaddr_can a = addr_of(index); if (connect(s, (void *)&a, sizeof a) < 0) out("connect", "%s", E(-1)); return s; }
static long bput(int s, int op, unsigned flags, unsigned count, int us1, int us2, unsigned id, int n, struct can_frame *f) { static struct bmsg m; memset(&m, 0, sizeof m); m.h.opcode = op; m.h.flags = flags; m.h.count = count; m.h.ival1.tv_sec = us1 / 1000000; m.h.ival1.tv_usec = us1 % 1000000; m.h.ival2.tv_sec = us2 / 1000000; m.h.ival2.tv_usec = us2 % 1000000; m.h.can_id = id; m.h.nframes = n; for (int i = 0; i < n; i++) m.f[i] = f[i]; return write(s, &m, sizeof m.h + 16 * n); }
static void bget(const char *name, int s, int wait)
{
    struct bmsg m; struct sockaddr_can a; socklen_t l = sizeof a; memset(&m, 0, sizeof m); if (!ready(s, wait)) { out(name, "nothing"); return; }
    long r = recvfrom(s, &m, sizeof m, 0, (void *)&a, &l); out(name, "%s op %d flags %x count %d iv %d,%d id %x n %d: %d %02x%02x index %d len %d", E(r), m.h.opcode, m.h.flags, m.h.count, (int)(m.h.ival1.tv_sec * 1000 + m.h.ival1.tv_usec / 1000), (int)(m.h.ival2.tv_sec * 1000 + m.h.ival2.tv_usec / 1000), m.h.can_id, m.h.nframes, m.f[0].can_dlc, m.f[0].data[0], m.f[0].data[1], a.can_ifindex == index0() ? 1 : a.can_ifindex ? 2 : 0, (int)l);
}
static void s_bcm(void)
{
    struct can_frame f[260]; for (int i = 0; i < 260; i++) f[i] = frame(0x300, 2, i); struct sockaddr_can a = addr_of(index0()); char b[4000];
    int s = socket(AF_CAN, SOCK_DGRAM, CAN_BCM), r = raw_on(index0()); out("unconnected.write", "%s", E(bput(s, TX_SEND, 0, 0, 0, 0, 0x300, 1, f))); out("bind", "%s", E(bind(s, (void *)&a, sizeof a))); out("connect.len7", "%s", E(connect(s, (void *)&a, 7))); struct sockaddr_can z = addr_of(4444); out("connect.unknown", "%s", E(connect(s, (void *)&z, sizeof z))); out("connect", "%s", E(connect(s, (void *)&a, sizeof a))); out("connect.again", "%s", E(connect(s, (void *)&a, sizeof a)));
    socklen_t l = sizeof z; memset(&z, 0, sizeof z); out("getsockname", "%s", E(getsockname(s, (void *)&z, &l))); int v = 1; out("setsockopt", "%s", E(setsockopt(s, SOL_CAN_RAW, CAN_RAW_LOOPBACK, &v, 4))); l = 4; out("getsockopt", "%s", E(getsockopt(s, SOL_CAN_RAW, CAN_RAW_LOOPBACK, &v, &l)));
    out("empty.read", "%s", E(recv(s, b, sizeof b, MSG_DONTWAIT))); out("short", "%s", E(write(s, b, 10))); memset(b, 0, sizeof b); out("zero", "%s", E(write(s, b, 56)));
    out("send", "%s", E(bput(s, TX_SEND, 0, 0, 0, 0, 0x300, 1, f))); out("send.heard", "%d", drain(r, 200)); out("send.n0", "%s", E(bput(s, TX_SEND, 0, 0, 0, 0, 0x300, 0, f))); out("send.n2", "%s", E(bput(s, TX_SEND, 0, 0, 0, 0, 0x300, 2, f)));
    out("tx.n0", "%s", E(bput(s, TX_SETUP, 0, 0, 0, 0, 0x300, 0, f))); out("tx.n257", "%s", E(bput(s, TX_SETUP, 0, 0, 0, 0, 0x300, 257, f))); out("tx.delete.none", "%s", E(bput(s, TX_DELETE, 0, 0, 0, 0, 0x300, 0, f))); out("tx.read.none", "%s", E(bput(s, TX_READ, 0, 0, 0, 0, 0x300, 0, f))); out("rx.delete.none", "%s", E(bput(s, RX_DELETE, 0, 0, 0, 0, 0x300, 0, f))); out("rx.read.none", "%s", E(bput(s, RX_READ, 0, 0, 0, 0, 0x300, 0, f))); out("op99", "%s", E(bput(s, 99, 0, 0, 0, 0, 0x300, 0, f))); out("op.TX_STATUS", "%s", E(bput(s, TX_STATUS, 0, 0, 0, 0, 0x300, 0, f)));
    out("tx.setup", "%s", E(bput(s, TX_SETUP, SETTIMER | STARTTIMER | TX_COUNTEVT, 3, 30000, 0, 0x300, 1, f))); ms(300); out("tx.counted", "%d", drain(r, 100)); bget("tx.expired", s, 100); out("tx.read", "%s", E(bput(s, TX_READ, 0, 0, 0, 0, 0x300, 0, f))); bget("tx.status", s, 300);
    out("tx.more", "%s", E(bput(s, TX_SETUP, 0, 0, 0, 0, 0x300, 2, f))); out("tx.update.announce", "%s", E(bput(s, TX_SETUP, TX_ANNOUNCE, 0, 0, 0, 0x300, 1, f + 5))); out("tx.announced", "%d", drain(r, 200)); out("tx.delete", "%s", E(bput(s, TX_DELETE, 0, 0, 0, 0, 0x300, 0, f)));
    out("tx.cyclic", "%s", E(bput(s, TX_SETUP, SETTIMER | STARTTIMER, 0, 0, 50000, 0x300, 3, f))); ms(525); int n = drain(r, 1); out("tx.cyclic.count", "%s", n >= 9 && n <= 13 ? "10..13" : E(n)); bput(s, TX_READ, 0, 0, 0, 0, 0x300, 0, f); bget("tx.cyclic.status", s, 300); bput(s, TX_DELETE, 0, 0, 0, 0, 0x300, 0, f); ms(100); drain(r, 50); ms(200); out("tx.deleted", "%d", drain(r, 50));
    out("tx.cpid", "%s", E(bput(s, TX_SETUP, TX_CP_CAN_ID | TX_ANNOUNCE, 0, 0, 0, 0x355, 1, f))); struct can_frame g; if (ready(r, 300)) { if (read(r, &g, 16)) {} out("tx.cpid.id", "%x", g.can_id); } out("tx.badtime", "%s", E(bput(s, TX_SETUP, SETTIMER, 0, -5, 0, 0x356, 1, f)));
    f[0].can_dlc = 9; out("tx.dlc9", "%s", E(bput(s, TX_SETUP, 0, 0, 0, 0, 0x357, 1, f))); f[0].can_dlc = 2;
    // receiving
    int w = raw_on(index0()); struct can_frame m = frame(0, 8, 0); memset(m.data, 0, 8); m.data[0] = 0xff;
    out("rx.setup", "%s", E(bput(s, RX_SETUP, SETTIMER, 0, 0, 0, 0x400, 1, &m))); put(w, 0x400, 2, 1); bget("rx.first", s, 300); put(w, 0x400, 2, 1); bget("rx.same", s, 150); put(w, 0x400, 2, 2); bget("rx.changed", s, 300); put(w, 0x400, 1, 2); bget("rx.shorter", s, 150); put(w, 0x400 | CAN_EFF_FLAG, 2, 9); bget("rx.eff", s, 150); put(w, 0x400 | CAN_RTR_FLAG, 2, 9); bget("rx.rtr", s, 150);
    out("rx.checkdlc", "%s", E(bput(s, RX_SETUP, RX_CHECK_DLC, 0, 0, 0, 0x400, 1, &m))); put(w, 0x400, 2, 2); bget("dlc.first", s, 300); put(w, 0x400, 1, 2); bget("dlc.shorter", s, 300); out("rx.read", "%s", E(bput(s, RX_READ, 0, 0, 0, 0, 0x400, 0, f))); bget("rx.status", s, 300);
    out("rx.more", "%s", E(bput(s, RX_SETUP, 0, 0, 0, 0, 0x400, 3, f))); out("rx.delete", "%s", E(bput(s, RX_DELETE, 0, 0, 0, 0, 0x400, 0, f))); put(w, 0x400, 2, 77); bget("rx.deleted", s, 150);
    out("rx.id", "%s", E(bput(s, RX_SETUP, RX_FILTER_ID, 0, 0, 0, 0x401, 0, f))); put(w, 0x401, 2, 1); bget("id.first", s, 300); put(w, 0x401, 2, 1); bget("id.second", s, 300); bput(s, RX_DELETE, 0, 0, 0, 0, 0x401, 0, f);
    out("rx.timeout", "%s", E(bput(s, RX_SETUP, SETTIMER | STARTTIMER | RX_FILTER_ID, 0, 100000, 0, 0x402, 0, f))); bget("timeout.start", s, 400); put(w, 0x402, 2, 1); bget("timeout.frame", s, 300); bget("timeout.again", s, 400); bget("timeout.once", s, 300); bput(s, RX_DELETE, 0, 0, 0, 0, 0x402, 0, f);
    out("rx.resume", "%s", E(bput(s, RX_SETUP, SETTIMER | STARTTIMER | RX_ANNOUNCE_RESUME, 0, 100000, 0, 0x403, 1, &m))); put(w, 0x403, 2, 1); bget("resume.frame", s, 300); bget("resume.timeout", s, 400); put(w, 0x403, 2, 1); bget("resume.same", s, 300); bput(s, RX_DELETE, 0, 0, 0, 0, 0x403, 0, f); drain(s, 50);
    out("rx.throttle", "%s", E(bput(s, RX_SETUP, SETTIMER, 0, 0, 300000, 0x404, 1, &m))); n = 0; for (int i = 0; i < 10; i++) { put(w, 0x404, 1, i); ms(50); } ms(500); n = drain(s, 100); out("throttle.count", "%s", n >= 2 && n <= 4 ? "2..4" : E(n)); bput(s, RX_DELETE, 0, 0, 0, 0, 0x404, 0, f);
    struct can_frame mux[3] = {frame(0, 8, 0), frame(0, 8, 0), frame(0, 8, 0)}; memset(mux[0].data, 0, 8); mux[0].data[0] = 0xff; memset(mux[1].data, 0, 8); mux[1].data[0] = 1; mux[1].data[1] = 0xff; memset(mux[2].data, 0, 8); mux[2].data[0] = 2; mux[2].data[1] = 0xff;
    out("rx.mux", "%s", E(bput(s, RX_SETUP, 0, 0, 0, 0, 0x405, 3, mux))); put(w, 0x405, 2, 1); bget("mux.1", s, 300); put(w, 0x405, 2, 2); bget("mux.2", s, 300); put(w, 0x405, 2, 3); bget("mux.3", s, 150); put(w, 0x405, 2, 1); bget("mux.1.same", s, 150); bput(s, RX_DELETE, 0, 0, 0, 0, 0x405, 0, f);
    drain(r, 50); f[0] = frame(0x406, 2, 0xaa); out("rx.rtrframe", "%s", E(bput(s, RX_SETUP, RX_RTR_FRAME, 0, 0, 0, 0x406 | CAN_RTR_FLAG, 1, f))); put(w, 0x406 | CAN_RTR_FLAG, 0, 0); ms(200); n = 0; int rep = 0; while (ready(r, 100)) { if (read(r, &g, 16)) {} n++; rep += g.can_id == 0x406 && g.data[0] == 0xaa; } out("rtr.reply", "%d", rep); out("rtr.bad", "%s", E(bput(s, RX_SETUP, RX_RTR_FRAME, 0, 0, 0, 0x407, 1, f)));
    // with all interfaces
    int q = bcm(0); out("any.tx", "%s", E(bput(q, TX_SEND, 0, 0, 0, 0, 0x300, 1, f))); out("any.rx", "%s", E(bput(q, RX_SETUP, RX_FILTER_ID, 0, 0, 0, 0x408, 0, f))); put(w, 0x408, 2, 1); bget("any.rx.got", q, 300); static struct bmsg bm; memset(&bm, 0, sizeof bm); bm.h.opcode = TX_SEND; bm.h.nframes = 1; bm.f[0] = f[0]; out("any.sendto", "%s", E(sendto(q, &bm, sizeof bm.h + 16, 0, (void *)&a, sizeof a)));
    struct pollfd p = {q, POLLIN | POLLOUT, 0}; poll(&p, 1, 0); out("poll", "%x", p.revents);
    out("rx.n258", "%s", E(bput(s, RX_SETUP, 0, 0, 0, 0, 0x409, 258, f))); out("rx.smallbuf", "%s", (bput(s, RX_SETUP, RX_FILTER_ID, 0, 0, 0, 0x40a, 0, f), put(w, 0x40a, 2, 1), ready(s, 300), E(recv(s, b, 20, 0))));
    close(s); ms(100); drain(r, 50); out("closed.silent", "%d", drain(r, 200));
}

static int tp(unsigned rx, unsigned tx, int flags, int *err)
{
    int s = socket(AF_CAN, SOCK_DGRAM, CAN_ISOTP); struct sockaddr_can a = addr_of(index0()); a.can_addr.tp.rx_id = rx; a.can_addr.tp.tx_id = tx;
    if (flags) { struct can_isotp_options o; memset(&o, 0, sizeof o); o.flags = flags; o.txpad_content = 0xaa; o.rxpad_content = 0xaa; setsockopt(s, SOL_CAN_ISOTP, CAN_ISOTP_OPTS, &o, sizeof o); }
    int r = bind(s, (void *)&a, sizeof a); if (err) *err = r; else if (r < 0) out("bind", "%s", E(r)); return s;
}
static void frames_of(const char *name, int r, int wait)
{
    char t[400] = ""; struct can_frame f; while (ready(r, wait) && recv(r, &f, 16, MSG_DONTWAIT) == 16 && strlen(t) < 300) { sprintf(t + strlen(t), " %x#", f.can_id & CAN_EFF_MASK); for (int i = 0; i < f.can_dlc && i < 4; i++) sprintf(t + strlen(t), "%02x", f.data[i]); sprintf(t + strlen(t), "/%d", f.can_dlc); } out(name, "%s", t);
}
static void s_isotp(void)
{
    char b[9000]; memset(b, 0x55, sizeof b); int e; socklen_t l; struct sockaddr_can a;
    int s = socket(AF_CAN, SOCK_DGRAM, CAN_ISOTP); if (s < 0) { out("socket", "%s", E(s)); return; }
    out("unbound.write", "%s", E(write(s, b, 3))); alarm(4); out("unbound.read", "%s", E(recv(s, b, 3, MSG_DONTWAIT))); alarm(60); l = sizeof a; int r = getsockname(s, (void *)&a, &l); out("unbound.name", "%s len %d", E(r), (int)l); struct pollfd p = {s, POLLIN | POLLOUT, 0}; poll(&p, 1, 0); out("unbound.poll", "%x", p.revents);
    a = addr_of(index0()); a.can_addr.tp.rx_id = 0x701; a.can_addr.tp.tx_id = 0x702; out("bind.len8", "%s", E(bind(s, (void *)&a, 8))); out("bind.len16", "%s", E(bind(s, (void *)&a, 16))); out("bind.again", "%s", E(bind(s, (void *)&a, sizeof a))); close(s);
    s = tp(0x701, 0x701, 0, &e); out("bind.same", "%s", E(e)); close(s); s = tp(0xfff, 0x702, 0, &e); out("bind.badid", "%s", E(e)); l = sizeof a; r = getsockname(s, (void *)&a, &l); out("bind.badid.name", "%s len %d rx %x tx %x", E(r), (int)l, a.can_addr.tp.rx_id, a.can_addr.tp.tx_id); close(s);
    s = socket(AF_CAN, SOCK_DGRAM, CAN_ISOTP); a = addr_of(0); a.can_addr.tp.rx_id = 1; a.can_addr.tp.tx_id = 2; out("bind.any", "%s", E(bind(s, (void *)&a, sizeof a))); close(s);
    int c = raw_on(index0()); s = tp(0x701, 0x702, 0, &e); l = sizeof a; memset(&a, 0, sizeof a); r = getsockname(s, (void *)&a, &l); out("name", "%s len %d rx %x tx %x", E(r), (int)l, a.can_addr.tp.rx_id, a.can_addr.tp.tx_id); l = sizeof a; out("peername", "%s", E(getpeername(s, (void *)&a, &l)));
    struct can_isotp_options o; memset(&o, 0, sizeof o); l = sizeof o; r = getsockopt(s, SOL_CAN_ISOTP, CAN_ISOTP_OPTS, &o, &l); out("opts", "%s len %d flags %x ft %u pad %x %x", E(r), (int)l, o.flags, o.frame_txtime, o.txpad_content, o.rxpad_content); out("opts.bound", "%s", E(setsockopt(s, SOL_CAN_ISOTP, CAN_ISOTP_OPTS, &o, sizeof o))); struct can_isotp_fc_options fc; l = sizeof fc; r = getsockopt(s, SOL_CAN_ISOTP, CAN_ISOTP_RECV_FC, &fc, &l); out("fc", "%s %d %d %d", E(r), fc.bs, fc.stmin, fc.wftmax); struct can_isotp_ll_options ll; l = sizeof ll; r = getsockopt(s, SOL_CAN_ISOTP, CAN_ISOTP_LL_OPTS, &ll, &l); out("ll", "%s %d %d %d", E(r), ll.mtu, ll.tx_dl, ll.tx_flags); l = 4; int v; out("opt99", "%s", E(getsockopt(s, SOL_CAN_ISOTP, 99, &v, &l)));
    out("write0", "%s", E(write(s, b, 0))); out("write7", "%s", E(write(s, b, 7))); frames_of("write7.frames", c, 200); out("write.toobig", "%s", E(write(s, b, 8301)));
    double t = now(); out("write20", "%s", E(write(s, b, 20))); out("write20.quick", "%d", now() - t < 0.5); poll(&p, 0, 0); p.fd = s; p.events = POLLIN | POLLOUT; poll(&p, 1, 0); out("write20.poll", "%x", p.revents); out("busy.nonblock", "%s", E(send(s, b, 5, MSG_DONTWAIT))); frames_of("write20.frames", c, 200); ms(1300); p.fd = s; p.events = POLLIN | POLLOUT; poll(&p, 1, 0); out("late.poll", "%x", p.revents); alarm(5); out("late.read", "%s", E(recv(s, b, 10, MSG_DONTWAIT))); out("late.read2", "%s", E(recv(s, b, 10, MSG_DONTWAIT))); l = 4; v = -1; getsockopt(s, SOL_SOCKET, SO_ERROR, &v, &l); out("late.SO_ERROR", "%d", v); alarm(60); close(s);
    s = tp(0x701, 0x702, CAN_ISOTP_WAIT_TX_DONE, &e); t = now(); r = write(s, b, 20); out("waitdone", "%s %s", E(r), now() - t > 0.8 && now() - t < 1.6 ? "about 1 s" : "other time"); close(s); drain(c, 50);
    // a peer
    int u = tp(0x702, 0x701, 0, &e); s = tp(0x701, 0x702, 0, &e); for (int i = 0; i < 3; i++) { static const int n[] = {5, 300, 4096}; r = write(s, b, n[i]); out("send", "%d %s", n[i], E(r)); char g[9000]; out("got", "%s", ready(u, 3000) ? E(recv(u, g, sizeof g, 0)) : "nothing"); }
    drain(c, 300); if (write(s, b, 30)) {} ready(u, 2000); out("peek", "%s", E(recv(u, b, 10, MSG_PEEK))); struct iovec iv = {b, 10}; memset(&a, 0, sizeof a); struct msghdr mh = {.msg_iov = &iv, .msg_iovlen = 1, .msg_name = &a, .msg_namelen = sizeof a}; r = recvmsg(u, &mh, MSG_DONTWAIT); out("short", "%s flags %x name %d rx %x tx %x", E(r), mh.msg_flags, (int)mh.msg_namelen, a.can_addr.tp.rx_id, a.can_addr.tp.tx_id); out("short.rest", "%s", E(recv(u, b, 10, MSG_DONTWAIT))); if (write(s, b, 30)) {} ready(u, 2000); out("trunc", "%s", E(recv(u, b, 10, MSG_TRUNC)));
    drain(c, 300); close(s); close(u);
    // the receiver's errors
    int w = raw_on(index0()); u = tp(0x702, 0x701, 0, &e); struct can_frame f = frame(0x702, 8, 0); memcpy(f.data, "\x10\x14" "abcdef", 8); if (write(w, &f, 16)) {} frames_of("ff.fc", c, 200); ms(1300); p.fd = u; p.events = POLLIN; poll(&p, 1, 0); out("ff.timeout.poll", "%x", p.revents); out("ff.timeout", "%s", E(recv(u, b, 10, MSG_DONTWAIT))); out("ff.timeout2", "%s", E(recv(u, b, 10, MSG_DONTWAIT)));
    if (write(w, &f, 16)) {} ms(50); memcpy(f.data, "\x22" "abcdefg", 8); if (write(w, &f, 16)) {} ms(100); out("cf.wrong", "%s", E(recv(u, b, 10, MSG_DONTWAIT))); drain(c, 100);
    memcpy(f.data, "\x1f\xff" "abcdef", 8); if (write(w, &f, 16)) {} frames_of("ff4095", c, 150); memcpy(f.data, "\x10\x00\x00\x00\x30\x00" "ab", 8); if (write(w, &f, 16)) {} frames_of("ff12288", c, 150); memcpy(f.data, "\x10\x05" "abcdef", 8); if (write(w, &f, 16)) {} frames_of("ff5", c, 150); memcpy(f.data, "\x00" "abcdefg", 8); if (write(w, &f, 16)) {} frames_of("sf0", c, 150); out("sf0.read", "%s", E(recv(u, b, 10, MSG_DONTWAIT))); f.can_dlc = 3; memcpy(f.data, "\x05" "ab", 3); if (write(w, &f, 16)) {} ms(50); out("sf.short", "%s", E(recv(u, b, 10, MSG_DONTWAIT))); ms(1300); drain(u, 20); out("left", "%s", E(recv(u, b, 10, MSG_DONTWAIT))); close(u);
    // the sender's
    u = tp(0x702, 0x701, 0, &e); drain(c, 50); if (write(u, b, 30)) {} ms(50); f = frame(0x702, 3, 0); memcpy(f.data, "\x32\0\0", 3); if (write(w, &f, 16)) {} ms(100); out("fc.overflow", "%s", E(recv(u, b, 10, MSG_DONTWAIT))); if (write(u, b, 30)) {} ms(50); memcpy(f.data, "\x35\0\0", 3); if (write(w, &f, 16)) {} ms(100); out("fc.unknown", "%s", E(recv(u, b, 10, MSG_DONTWAIT))); if (write(u, b, 30)) {} ms(50); memcpy(f.data, "\x31\0\0", 3); if (write(w, &f, 16)) {} ms(800); if (write(w, &f, 16)) {} ms(800); memcpy(f.data, "\x30\0\0", 3); drain(c, 20); if (write(w, &f, 16)) {} frames_of("fc.wait.then.go", c, 200); close(u);
    // padding, addresses
    s = tp(0x701, 0x702, CAN_ISOTP_TX_PADDING, &e); drain(c, 50); if (write(s, b, 3)) {} frames_of("pad", c, 200); close(s); s = tp(0x701, 0x702, CAN_ISOTP_EXTEND_ADDR, &e); if (write(s, b, 3)) {} frames_of("ext", c, 200); close(s); s = tp(0x701, 0x702, CAN_ISOTP_SF_BROADCAST, &e); out("sfb.7", "%s", E(write(s, b, 7))); out("sfb.8", "%s", E(write(s, b, 8))); drain(c, 50); close(s);
    s = socket(AF_CAN, SOCK_DGRAM, CAN_ISOTP); struct can_isotp_ll_options bad = {16, 9, 0}; out("ll.bad", "%s", E(setsockopt(s, SOL_CAN_ISOTP, CAN_ISOTP_LL_OPTS, &bad, sizeof bad))); struct can_isotp_ll_options fdl = {72, 64, 0}; out("ll.fd", "%s", E(setsockopt(s, SOL_CAN_ISOTP, CAN_ISOTP_LL_OPTS, &fdl, sizeof fdl))); out("opts.size", "%s", E(setsockopt(s, SOL_CAN_ISOTP, CAN_ISOTP_OPTS, &bad, 2))); out("level", "%s", E(setsockopt(s, SOL_CAN_RAW, 1, &bad, 2))); out("fc3+2", "%s", E(setsockopt(s, SOL_CAN_ISOTP, CAN_ISOTP_OPTS, &o, sizeof o))); close(s);
    s = tp(0x701, 0x702, 0, &e); out("sendto", "%s", (a = addr_of(index0()), E(sendto(s, b, 3, 0, (void *)&a, sizeof a)))); out("connect", "%s", E(connect(s, (void *)&a, sizeof a))); out("shutdown", "%s", E(shutdown(s, SHUT_RDWR)));
}

static void under(const char *name, void (*what)(void), int seconds)
{
    fflush(stdout); pid_t c = fork();
    if (!c) { section = name; alarm(seconds); what(); fflush(stdout); exit(0); }
    int st; waitpid(c, &st, 0); section = name; if (WIFSIGNALED(st)) out("ENDED", "by signal %d", WTERMSIG(st));
}
static char **args; static void fds(void) { s_fds(args); }
int main(int argc, char **argv)
{
    if (argc > 2 && !strcmp(argv[1], "--send")) { return put(atoi(argv[2]), 0x100, 1, 1) == 16 ? 7 : errno == EBADF ? 9 : 8; }
    char self[4096]; long n = readlink("/proc/self/exe", self, sizeof self - 1); self[n > 0 ? n : 0] = 0; char *me[] = {self, NULL}; args = me; signal(SIGPIPE, SIG_IGN);
    const char *only = argc > 1 ? argv[1] : NULL;
    struct { const char *n; void (*f)(void); int s; } t[] = {{"socket", s_socket, 20}, {"bind", s_bind, 20}, {"options", s_options, 20}, {"ioctl", s_ioctl, 20}, {"write", s_write, 30}, {"read", s_read, 40}, {"efaultw", s_efault_write, 5}, {"efaultr", s_efault_read, 5}, {"efaulto", s_efault_opt, 5}, {"efaulti", s_efault_ioctl, 5}, {"errqueue", s_errqueue, 3}, {"errqueue2", s_errqueue2, 3}, {"overflow", s_overflow, 60}, {"loop", s_loop, 60}, {"poll", s_poll, 40}, {"fds", fds, 60}, {"bcm", s_bcm, 60}, {"isotp", s_isotp, 90}};
    for (unsigned i = 0; i < sizeof t / sizeof *t; i++) if (!only || !strcmp(only, t[i].n)) under(t[i].n, t[i].f, t[i].s);
    return 0;
}
