/* What kinds.py does, in C on vcinpl2: keeper PLACE NUMBER; words on its input, its account as a line of JSON. */
#include <vcinpl2.h>

#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static HANDLE channel;
static long taken, turned_away, got, lost, others;

static void ok(HRESULT result, const char *what)
{
    if (result != VCI_OK) {
        fprintf(stderr, "%s: %08X\n", what, (unsigned)result);
        exit(1);
    }
}

static void open_board(const char *place)
{
    HANDLE devices, device, control;
    VCIDEVICEINFO info;
    CANBTP rate = CAN_BTP_500KB, none = CAN_BTP_EMPTY;

    ok(vciInitialize(), "vciInitialize");
    ok(vciEnumDeviceOpen(&devices), "vciEnumDeviceOpen");
    do
        ok(vciEnumDeviceNext(devices, &info), "vciEnumDeviceNext");
    while (strncmp(info.UniqueHardwareId.AsChar, place, sizeof info.UniqueHardwareId.AsChar) != 0);
    ok(vciDeviceOpen(&info.VciObjectId, &device), "vciDeviceOpen");
    ok(canChannelOpen(device, 0, FALSE, &channel), "canChannelOpen");
    ok(canChannelInitialize(channel, 60000, 1, 64, 1, 0, CAN_FILTER_PASS), "canChannelInitialize");
    ok(canChannelActivate(channel, TRUE), "canChannelActivate");
    ok(canControlOpen(device, 0, &control), "canControlOpen");
    ok(canControlInitialize(control, CAN_OPMODE_STANDARD, 0, CAN_FILTER_PASS, CAN_FILTER_PASS, 0, 0, &rate, &none),
       "canControlInitialize");
    ok(canControlStart(control, TRUE), "canControlStart");
}

static void read_all(void)
{
    CANMSG2 message;

    while (canChannelPeekMessage(channel, &message) == VCI_OK) {
        got += message.uMsgInfo.Bits.type == CAN_MSGTYPE_DATA;
        others += message.uMsgInfo.Bits.type != CAN_MSGTYPE_DATA;
        lost += message.uMsgInfo.Bits.ovr ? 1000000 : 0; /* it does not say how many */
    }
}

static void send_one(unsigned id)
{
    CANMSG2 message;

    memset(&message, 0, sizeof message);
    message.dwMsgId = id;
    message.uMsgInfo.Bits.dlc = 4;
    memcpy(message.abData, &taken, 4);
    if (canChannelPostMessage(channel, &message) == VCI_OK)
        taken++;
    else
        turned_away++;
}

static double now(void)
{
    struct timespec time;

    clock_gettime(CLOCK_MONOTONIC, &time);
    return time.tv_sec + time.tv_nsec / 1e9;
}

int main(int count, char **words)
{
    unsigned id = 0x100 + (count > 2 ? atoi(words[2]) : 0);
    int sends = 0;
    double next = 0;
    char line[64];

    setvbuf(stdin, NULL, _IONBF, 0);
    open_board(words[1]);
    puts("at it");
    fflush(stdout);
    for (;;) {
        struct pollfd input = {0, POLLIN, 0};

        if (poll(&input, 1, 50) > 0) {
            if (fgets(line, sizeof line, stdin) == NULL)
                return 0;
            if (strcmp(line, "account\n") == 0) {
                read_all();
                printf("{\"taken\": %ld, \"turned_away\": %ld, \"got\": %ld, \"others\": %ld, \"lost\": %ld, \"waiting\": 0}\n",
                       taken, turned_away, got, others, lost);
                fflush(stdout);
            } else {
                sends = strcmp(line, "go\n") == 0;
            }
        }
        read_all();
        if (sends && now() >= next) {
            next = now() + 0.1;
            send_one(id);
        }
    }
}
