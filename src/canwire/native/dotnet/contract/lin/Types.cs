// LIN's enumerations. Source: lintype.h; VCI V3 .NET manual 4.3; the vendor's published contract of Ixxat.Vci4.
using System;

#if VCI3
namespace Ixxat.Vci3.Bal.Lin
#else
namespace Ixxat.Vci4.Bal.Lin
#endif
{
    /// <summary>What a controller can do.</summary>
    [Flags]
    public enum LinFeatures
    {
        Master = 0x0001,
        Autorate = 0x0002,
        ErrFrame = 0x0004,
        Busload = 0x0008,
        Sleep = 0x0010,
        Wakeup = 0x0020
    }

    /// <summary>How a line is set up.</summary>
    [Flags]
    public enum LinOperatingModes : int
    {
        Slave = 0x00,
        Master = 0x01,
        Errors = 0x02
    }

    /// <summary>The state of a controller.</summary>
    [Flags]
    public enum LinCtrlStatus : long
    {
        Overrun = 0x01,
        InInit = 0x10
    }

    /// <summary>What a message is; a master sends Data, Sleep and Wakeup, a slave Wakeup alone.</summary>
    public enum LinMessageType : int
    {
        Data = 0x00,
        Info = 0x01,
        Error = 0x02,
        Status = 0x03,
        Wakeup = 0x04,
        TimeOverrun = 0x06,
        Sleep = 0x05
    }

    /// <summary>Byte 0 of an Info message.</summary>
    public enum LinMsgInfoValue
    {
        Start = 1,
        Stop = 2,
        Reset = 3
    }

    /// <summary>Byte 0 of an Error message.</summary>
    public enum LinMsgError
    {
        Bit = 1,
        Crc = 2,
        Parity = 3,
        SlaveNoResponse = 4,
        Sync = 5,
        NoBus = 6,
        Other = 7
    }

    /// <summary>What InitLine takes.</summary>
    public struct LinInitLine
    {
        public LinOperatingModes OperatingMode;
        public LinBitrate Bitrate;
    }
}
