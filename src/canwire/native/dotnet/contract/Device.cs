// A board. Source: VCI V3 .NET manual 2.2, 2.3; the vendor's published contract of Ixxat.Vci4.
using System;

#if VCI3
namespace Ixxat.Vci3
#else
namespace Ixxat.Vci4
#endif
{
    /// <summary>The kind of bus of a connector.</summary>
    public enum VciBusType
    {
        Unknown = 0,
        Can = 1,
        Lin = 2,
#if VCI3
        FlexRay = 3,
        KLine = 4
#else
        FlexRay = 4
#endif
    }

    /// <summary>One connector of a board.</summary>
#if VCI3
    public struct VciCtrlInfo
    {
        internal VciCtrlInfo(VciBusType bus, object controller) : this()
        {
            BusType = bus;
            ControllerType = controller;
        }

        public VciBusType BusType { get; private set; }

        /// <summary>A CanCtrlType on a CAN bus, else null.</summary>
        public object ControllerType { get; private set; }
    }
#else
    public interface IVciCtrlInfo
    {
        VciBusType BusType { get; }

        /// <summary>A CanCtrlType on a CAN bus, else null.</summary>
        object ControllerType { get; }
    }
#endif

    /// <summary>A board as it was when it was found; Equipment and opening it need it plugged in.</summary>
    public interface IVciDevice : IDisposable
    {
        /// <summary>Another one whenever the board is plugged in.</summary>
        long VciObjectId { get; }

        /// <summary>The same for all boards of a kind.</summary>
        Guid DeviceClass { get; }

        Version DriverVersion { get; }

        Version HardwareVersion { get; }

        /// <summary>The board's for ever: a string where it is text ("HW123456"), else a Guid.</summary>
        object UniqueHardwareId { get; }

        string Description { get; }

        string Manufacturer { get; }

#if VCI3
        VciCtrlInfo[] Equipment { get; }
#else
        IVciCtrlInfo[] Equipment { get; }
#endif

        /// <summary>The connectors; any number of programs may open them.</summary>
        Bal.IBalObject OpenBusAccessLayer();
    }
}
