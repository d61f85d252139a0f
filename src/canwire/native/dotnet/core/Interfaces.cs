// IIDs and the numbers of methods in vtables. Source: vcisdk.h.
using System;

namespace Canwire.Native
{
    internal static class Iid
    {
        internal static readonly Guid BusAccessLayer = new Guid("3CB880F4-2791-40BD-B852-09349D1A7B37"); // CLSID_VCIBAL
        internal static readonly Guid BalObject = new Guid("A2B958AA-9188-4CDB-8307-25D9F1F843E9");
        internal static readonly Guid CanSocket = new Guid("48965C25-9F8D-4E4D-8DE6-F029808C9ED2");
        internal static readonly Guid CanSocket2 = new Guid("D914F5A7-12FA-41F6-8AB4-4EA89F1C5F1E");
        internal static readonly Guid CanControl = new Guid("D213C143-7039-4D1D-ACED-1390289C8EBA");
        internal static readonly Guid CanControl2 = new Guid("EFD3A8E2-09E3-4115-869F-93E579167431");
        internal static readonly Guid CanScheduler = new Guid("C936498F-EC52-4C74-B3FE-A472BA7365BA");
        internal static readonly Guid CanScheduler2 = new Guid("70E3E8B8-852F-48E0-BDDB-B10A0C44CB3F");
        internal static readonly Guid LinSocket = new Guid("EF865638-6D07-4A46-A838-4BAFED359B1A");
        internal static readonly Guid LinControl = new Guid("4D58EF55-4F01-451E-911F-17C223A8B8F0");
    }

    internal static class DeviceManagerSlot
    {
        internal const int EnumDevices = 3, OpenDevice = 4;
    }

    internal static class EnumDeviceSlot
    {
        internal const int Next = 3, Reset = 5, AssignEvent = 6;
    }

    internal static class DeviceSlot
    {
        internal const int GetDeviceCaps = 4, OpenComponent = 5;
    }

    internal static class BalSlot
    {
        internal const int GetFeatures = 3, OpenSocket = 4;
    }

    /// <summary>ICanSocket, ICanSocket2, ILinSocket.</summary>
    internal static class SocketSlot
    {
        internal const int GetCapabilities = 4, GetLineStatus = 5, CreateQueue = 6;
    }

    /// <summary>ICanControl.</summary>
    internal static class ControlSlot
    {
        internal const int DetectBaud = 3, InitLine = 4, ResetLine = 5, StartLine = 6, StopLine = 7, GetLineStatus = 8;
        internal const int SetAccFilter = 9, AddFilterIds = 10, RemFilterIds = 11;
    }

    /// <summary>ICanControl2, as far as it is not as ICanControl.</summary>
    internal static class Control2Slot
    {
        internal const int SetAccFilter = 11, AddFilterIds = 12, RemFilterIds = 13;
    }

    /// <summary>ILinControl.</summary>
    internal static class LinControlSlot
    {
        internal const int InitLine = 3, ResetLine = 4, StartLine = 5, StopLine = 6, WriteMessage = 7;
    }

    /// <summary>ICanChannel, ICanChannel2, ILinMonitor; the last one has no writer.</summary>
    internal static class QueueSlot
    {
        internal const int Initialize = 3, Activate = 4, Deactivate = 5, GetReader = 6, GetWriter = 7;
        internal const int ChannelStatus = 8, MonitorStatus = 7;
        internal const int GetFilterMode = 10, SetFilterMode = 11, SetAccFilter = 12, AddFilterIds = 13, RemFilterIds = 14;
    }

    /// <summary>ICanScheduler, ICanScheduler2.</summary>
    internal static class SchedulerSlot
    {
        internal const int Resume = 3, Suspend = 4, Reset = 5, GetStatus = 6, AddMessage = 7, RemMessage = 8;
        internal const int StartMessage = 9, StopMessage = 10;
    }

    /// <summary>IFifoReader, IFifoWriter.</summary>
    internal static class FifoSlot
    {
        internal const int Lock = 3, Unlock = 4, AssignEvent = 5, SetThreshold = 6, GetThreshold = 7, GetCapacity = 8;
        internal const int GetFillCount = 10, GetFreeCount = 11, Entry = 12, Acquire = 13, Release = 14;
    }
}
