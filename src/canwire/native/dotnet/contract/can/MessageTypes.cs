// What messages are. Source: cantype.h; VCI V3 .NET manual 4.2; the vendor's published contract of Ixxat.Vci4.
#if VCI3
namespace Ixxat.Vci3.Bal.Can
#else
namespace Ixxat.Vci4.Bal.Can
#endif
{
    /// <summary>What a message is; only Data can be sent.</summary>
    public enum CanMsgFrameType : int
    {
        Data = 0,
        Info = 1,
        Error = 2,
        Status = 3,
        Wakeup = 4,
        TimeOverrun = 5,
        TimeReset = 6
    }

    /// <summary>Which filter let a message in.</summary>
    public enum CanMsgAccReason : int
    {
        Reject = 0x00,
        Always = 0xFF,
        Filter1 = 0x01,
        Filter2 = 0x02
    }

    /// <summary>Byte 0 of an Info message.</summary>
    public enum CanMsgInfoValue
    {
        Start = 1,
        Stop = 2,
        Reset = 3
    }

    /// <summary>Byte 0 of an Error message.</summary>
    public enum CanMsgError
    {
        Stuff = 1,
        Form = 2,
        Acknowledge = 3,
        Bit = 4,
        Crc = 6,
#if VCI3
        Other = 7
#else
        Fdb = 5,
        Dlc = 7,
        Other = 8
#endif
    }

    /// <summary>What counts up after each transmission of a cyclic message.</summary>
    public enum CanCyclicTXIncMode : int
    {
        NoInc = 0x00,
        IncId = 0x01,
#if VCI3
        Inc1 = IncId,
#endif
        Inc8 = 0x02,
        Inc16 = 0x03
    }

    /// <summary>The state of a cyclic message.</summary>
    public enum CanCyclicTXStatus : int
    {
        Empty = 0x00,
        Busy = 0x01,
        Done = 0x02
    }
}
