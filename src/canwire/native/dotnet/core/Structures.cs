// Structures as vcitype.h, baltype.h, cantype.h and lintype.h have them, packed.
using System;
using System.Runtime.InteropServices;

namespace Canwire.Native
{
    [StructLayout(LayoutKind.Sequential, Pack = 1)]
    internal struct VciVersionInfo
    {
        internal uint Major, Minor, Release, Build, OsMajor, OsMinor, OsBuild, OsPlatform;
    }

    [StructLayout(LayoutKind.Sequential, Pack = 1)]
    internal unsafe struct VciDeviceInfo
    {
        internal const int HardwareIdBytes = 16, DescriptionBytes = 128, ManufacturerBytes = 126;

        internal long ObjectId;
        internal Guid DeviceClass;
        internal byte DriverMajor, DriverMinor;
        internal ushort DriverBuild;
        internal byte HardwareBranch, HardwareMajor, HardwareMinor, HardwareBuild;
        internal fixed byte HardwareId[HardwareIdBytes];
        internal fixed byte Description[DescriptionBytes];
        internal fixed byte Manufacturer[ManufacturerBytes];
        internal ushort DriverRelease;
    }

    [StructLayout(LayoutKind.Sequential, Pack = 1)]
    internal unsafe struct VciDeviceCaps
    {
        internal ushort Count;
        internal fixed ushort Types[32];
    }

    [StructLayout(LayoutKind.Sequential, Pack = 1)]
    internal unsafe struct BalFeatures
    {
        internal ushort Major, Minor, Count;
        internal fixed ushort Types[32];
    }

    [StructLayout(LayoutKind.Sequential, Pack = 1)]
    internal struct CanBtp
    {
        internal uint Mode, Prescaler;
        internal ushort TimeSegment1, TimeSegment2, Sjw, Delay;
    }

    [StructLayout(LayoutKind.Sequential, Pack = 1)]
    internal struct CanCapabilities
    {
        internal ushort Controller, Coupling;
        internal uint Features, Clock, TimeStampDivisor, CyclicDivisor, CyclicTicks, DelayDivisor, DelayTicks;
    }

    [StructLayout(LayoutKind.Sequential, Pack = 1)]
    internal struct CanCapabilities2
    {
        internal ushort Controller, Coupling;
        internal uint Features, CanClock;
        internal CanBtp SlowestArbitration, FastestArbitration, SlowestData, FastestData;
        internal uint TimeStampClock, TimeStampDivisor, CyclicClock, CyclicDivisor, CyclicTicks;
        internal uint DelayClock, DelayDivisor, DelayTicks;
    }

    [StructLayout(LayoutKind.Sequential, Pack = 1)]
    internal unsafe struct CanBtrTable
    {
        internal const int Room = 64;

        internal byte Count, Index;
        internal fixed byte Btr0[Room];
        internal fixed byte Btr1[Room];
    }

    [StructLayout(LayoutKind.Sequential, Pack = 1)]
    internal struct CanInitLine
    {
        internal byte Mode, Reserved, Btr0, Btr1;
    }

    [StructLayout(LayoutKind.Sequential, Pack = 1)]
    internal struct CanInitLine2
    {
        internal byte Mode, ExtendedMode, StandardFilter, ExtendedFilter;
        internal uint StandardIds, ExtendedIds;
        internal CanBtp Standard, Fast;
    }

    [StructLayout(LayoutKind.Sequential, Pack = 1)]
    internal struct CanLineState
    {
        internal byte Mode, Btr0, Btr1, Load;
        internal uint Status;
    }

    [StructLayout(LayoutKind.Sequential, Pack = 1)]
    internal struct CanLineState2
    {
        internal byte Mode, ExtendedMode, Load, Reserved;
        internal CanBtp Standard, Fast;
        internal uint Status;
    }

    [StructLayout(LayoutKind.Sequential, Pack = 1)]
    internal struct CanChannelState
    {
        internal CanLineState Line;
        internal int Activated, Overrun;
        internal byte ReceiveLoad, TransmitLoad;
    }

    [StructLayout(LayoutKind.Sequential, Pack = 1)]
    internal struct CanChannelState2
    {
        internal CanLineState2 Line;
        internal byte Activated, Overrun, ReceiveLoad, TransmitLoad;
    }

    [StructLayout(LayoutKind.Sequential, Pack = 1)]
    internal unsafe struct CanSchedulerState
    {
        internal byte Task;
        internal fixed byte Messages[16];
    }

    [StructLayout(LayoutKind.Sequential, Pack = 1)]
    internal struct CanSchedulerState2
    {
        internal CanLineState2 Line;
        internal CanSchedulerState List;
    }

    [StructLayout(LayoutKind.Sequential, Pack = 1)]
    internal unsafe struct CanMsg
    {
        internal const int Bytes = 8;

        internal uint Time, Identifier, Info;
        internal fixed byte Data[Bytes];
    }

    [StructLayout(LayoutKind.Sequential, Pack = 1)]
    internal unsafe struct CanMsg2
    {
        internal const int Bytes = 64;

        internal uint Time, Reserved, Identifier, Info;
        internal fixed byte Data[Bytes];
    }

    /// <summary>CANCYCLICTXMSG2, whose beginning is CANCYCLICTXMSG.</summary>
    [StructLayout(LayoutKind.Sequential, Pack = 1)]
    internal unsafe struct CanCyclicMsg
    {
        internal ushort CycleTicks;
        internal byte Mode, Index;
        internal uint Identifier, Info;
        internal fixed byte Data[CanMsg2.Bytes];
    }

    [StructLayout(LayoutKind.Sequential, Pack = 1)]
    internal struct LinCapabilities
    {
        internal uint Features, Clock, TimeStampDivisor;
    }

    [StructLayout(LayoutKind.Sequential, Pack = 1)]
    internal struct LinInit
    {
        internal byte Mode, Reserved;
        internal ushort Bitrate;
    }

    [StructLayout(LayoutKind.Sequential, Pack = 1)]
    internal struct LinLineState
    {
        internal byte Mode, Load;
        internal ushort Bitrate;
        internal uint Status;
    }

    [StructLayout(LayoutKind.Sequential, Pack = 1)]
    internal struct LinMonitorState
    {
        internal LinLineState Line;
        internal int Activated, Overrun;
        internal byte ReceiveLoad;
    }

    [StructLayout(LayoutKind.Sequential, Pack = 1)]
    internal unsafe struct LinMsg
    {
        internal const int Bytes = 8;

        internal uint Time;
        internal byte ProtId, Type, Length, Flags;
        internal fixed byte Data[Bytes];
    }
}
