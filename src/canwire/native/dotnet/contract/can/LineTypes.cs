// What CAN lines are and can do. Source: cantype.h; VCI V3 .NET manual 4.2; the contract of Ixxat.Vci4.
using System;

#if VCI3
namespace Ixxat.Vci3.Bal.Can
#else
namespace Ixxat.Vci4.Bal.Can
#endif
{
    /// <summary>How a controller is coupled to its bus.</summary>
    [Flags]
    public enum CanBusCouplings : int
    {
        Undefined = 0x0000,
        LowSpeed = 0x0001,
        HighSpeed = 0x0002
    }

    /// <summary>The kind of CAN controller.</summary>
    public enum CanCtrlType : int
    {
        Unknown = 0,
        Intel82527 = 1,
        Intel82C200 = 2,
        Intel81C90 = 3,
        Intel81C92 = 4,
        SJA1000 = 5,
        Infineon82C900 = 6,
        TouCAN = 7,
        msCAN = 8,
        FLEXCAN = 9,
        IFI_CAN = 10,
        C_CAN = 11,
        bxCAN = 12,
        IFI_CAN_FD = 13,
        M_CAN = 14
    }

    /// <summary>Which of a line's two filters.</summary>
    public enum CanFilter : int
    {
        Std = 1,
        Ext = 2
    }

    /// <summary>Masks for SetAccFilter.</summary>
    public enum CanAccMask : uint
    {
        All = 0x00000000,
        None = 0xFFFFFFFF
    }

    /// <summary>Codes for SetAccFilter.</summary>
    public enum CanAccCode : uint
    {
        All = 0x00000000,
        None = 0x80000000
    }

    /// <summary>What a controller can do.</summary>
    [Flags]
    public enum CanFeatures
    {
        StdOrExt = 0x00000001,
        StdAndExt = 0x00000002,
        RemoteFrame = 0x00000004,
        ErrFrame = 0x00000008,
        Busload = 0x00000010,
        IdFilter = 0x00000020,
        ListOnly = 0x00000040,
        Scheduler = 0x00000080,
        GenErrFrame = 0x00000100,
        DelayedTX = 0x00000200,
        SingleShot = 0x00000400,
        HighPriorityMsg = 0x00000800,
#if VCI3
        CanFd = 0x00001000
#else
        AutoBaudrate = 0x00001000,
        ExtendedDataLength = 0x00002000,
        FastDataRate = 0x00004000,
        IsoCanFd = 0x00008000,
        NonIsoCanFd = 0x00010000,
        LongBitTimeStamp = 0x00020000
#endif
    }

    /// <summary>How a line is set up.</summary>
    [Flags]
    public enum CanOperatingModes : byte
    {
        Undefined = 0x00,
        Standard = 0x01,
        Extended = 0x02,
        ModeMask = Standard + Extended,
        ErrFrame = 0x04,
        ListenOnly = 0x08,
#if VCI3
        LowSpeed = 0x10
#else
        LowSpeed = 0x10,
        AutoBaudrate = 0x20
#endif
    }

    /// <summary>The state of a controller.</summary>
    [Flags]
    public enum CanCtrlStatus : long
    {
        TxPending = 0x00000001,
        Overrun = 0x00000002,
        ErrLimit = 0x00000004,
        BusOff = 0x00000008,
        InInit = 0x00000010,
        BusCErr = 0x00000020
    }

#if !VCI3
    /// <summary>How a CAN FD line is set up.</summary>
    [Flags]
    public enum CanExtendedOperatingModes : byte
    {
        Undefined = 0x00,
        ExtendedDataLength = 0x01,
        FastDataRate = 0x02,
        NonIsoCanFd = 0x04
    }

    /// <summary>What a filter does; PassSelfReceptions is for a channel's Initialize.</summary>
    [Flags]
    public enum CanFilterModes : int
    {
        Invalid = 0x00,
        Lock = 0x01,
        Pass = 0x02,
        Inclusive = 0x03,
        Exclusive = 0x04,
        PassSelfReceptions = 0x80
    }
#endif
}
