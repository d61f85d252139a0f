/* What the listings of CanWrite and CanRead use of the manual's header; its values are tested in tests/candrv. */
#define IOCTL_CAN_SET_BAUDRATE 0x8007200C
#define IOCTL_CAN_GET_BAUDRATE 0x80072010
#define IOCTL_CAN_WRITE_ACCEPTANCE_FILTER 0x8007A004

typedef struct tagCAN_ACCEPTANCE_FILTER {
    unsigned int code, mask;
} CAN_ACCEPTANCE_FILTER;
