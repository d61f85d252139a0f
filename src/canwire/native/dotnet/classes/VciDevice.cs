// A board. Source: VCI V3 .NET manual 2.2, 2.3; the vendor's published contract of Ixxat.Vci4.
using System;
using System.Linq;
using System.Text;
using Canwire.Native;

#if VCI3
namespace Ixxat.Vci3
#else
namespace Ixxat.Vci4
#endif
{
    using Bal;
    using Bal.Can;

    internal sealed unsafe class VciDevice : Disposable, IVciDevice
    {
        private VciDeviceInfo info;
        private NativeObject device;

        internal VciDevice(VciDeviceInfo info)
        {
            this.info = info;
        }

        public long VciObjectId
        {
            get
            {
                Alive();
                return info.ObjectId;
            }
        }

        public Guid DeviceClass
        {
            get
            {
                Alive();
                return info.DeviceClass;
            }
        }

        public Version DriverVersion
        {
            get
            {
                Alive();
                return new Version(info.DriverMajor, info.DriverMinor, info.DriverRelease, info.DriverBuild);
            }
        }

        public Version HardwareVersion
        {
            get
            {
                Alive();
                return new Version(info.HardwareMajor, info.HardwareMinor, info.HardwareBranch, info.HardwareBuild);
            }
        }

        public object UniqueHardwareId
        {
            get
            {
                Alive();
                byte[] id;
                fixed (byte* from = info.HardwareId)
                    id = Bytes(from, VciDeviceInfo.HardwareIdBytes);
                int length = Array.FindLastIndex(id, one => one != 0) + 1;
                bool isText = length > 1 && id.Take(length).All(one => one >= 0x20 && one < 0x7F);
                return isText ? (object)Encoding.ASCII.GetString(id, 0, length) : new Guid(id);
            }
        }

        public string Description
        {
            get
            {
                Alive();
                fixed (byte* from = info.Description)
                    return Text(Bytes(from, VciDeviceInfo.DescriptionBytes));
            }
        }

        public string Manufacturer
        {
            get
            {
                Alive();
                fixed (byte* from = info.Manufacturer)
                    return Text(Bytes(from, VciDeviceInfo.ManufacturerBytes));
            }
        }

#if VCI3
        public VciCtrlInfo[] Equipment
        {
            get { return Connectors().Select(word => Told(word)).ToArray(); }
        }

        private static VciCtrlInfo Told(ushort word)
        {
            return new VciCtrlInfo(BusTypes.Of(word), BusTypes.ControllerOf(word));
        }
#else
        public IVciCtrlInfo[] Equipment
        {
            get { return Connectors().Select(word => (IVciCtrlInfo)new VciCtrlInfo(word)).ToArray(); }
        }
#endif

        public IBalObject OpenBusAccessLayer()
        {
            Alive();
            IntPtr made;
            Guid layer = Iid.BusAccessLayer, iid = Iid.BalObject;
            Check(Device().Call(DeviceSlot.OpenComponent, &layer, &iid, &made));
            return new BalObject(made);
        }

        /// <summary>Two objects of the same plugged-in board are equal.</summary>
        public override bool Equals(object obj)
        {
            var other = obj as VciDevice;
            return other != null && info.ObjectId == other.info.ObjectId;
        }

        public override int GetHashCode()
        {
            return info.ObjectId.GetHashCode();
        }

        public override string ToString()
        {
            return string.Format("[{0:X16}] {1} - {2}", (ulong)VciObjectId, Manufacturer, Description);
        }

        private NativeObject Device()
        {
            if (device == null)
                using (var manager = new VciDeviceManager())
                    device = Hold(manager.Open(info.ObjectId));
            return device;
        }

        private ushort[] Connectors()
        {
            Alive();
            VciDeviceCaps caps;
            Check(Device().Call(DeviceSlot.GetDeviceCaps, &caps));
            var words = new ushort[caps.Count];
            for (int at = 0; at < words.Length; at++)
                words[at] = caps.Types[at];
            return words;
        }

        private static byte[] Bytes(byte* from, int count)
        {
            var made = new byte[count];
            for (int at = 0; at < count; at++)
                made[at] = from[at];
            return made;
        }

        private static string Text(byte[] bytes)
        {
            int end = Array.IndexOf(bytes, (byte)0);
            return Encoding.UTF8.GetString(bytes, 0, end < 0 ? bytes.Length : end);
        }
    }

#if !VCI3
    internal sealed class VciCtrlInfo : IVciCtrlInfo
    {
        private readonly ushort word;

        internal VciCtrlInfo(ushort word)
        {
            this.word = word;
        }

        public VciBusType BusType
        {
            get { return BusTypes.Of(word); }
        }

        public object ControllerType
        {
            get { return BusTypes.ControllerOf(word); }
        }

        public override bool Equals(object obj)
        {
            var other = obj as VciCtrlInfo;
            return other != null && word == other.word;
        }

        public override int GetHashCode()
        {
            return word;
        }
    }
#endif

    /// <summary>The words that say what a connector is: kind of bus and controller. Source: vcitype.h.</summary>
    internal static class BusTypes
    {
        internal static VciBusType Of(ushort word)
        {
            var kind = (VciBusType)(word >> 8);
#if VCI3
            return kind == VciBusType.Can || kind == VciBusType.Lin ? kind : VciBusType.Unknown;
#else
            return Enum.IsDefined(typeof(VciBusType), kind) ? kind : VciBusType.Unknown;
#endif
        }

        internal static object ControllerOf(ushort word)
        {
            var kind = (CanCtrlType)(word & 0xFF);
            if (Of(word) != VciBusType.Can)
                return null;
            return Enum.IsDefined(typeof(CanCtrlType), kind) ? kind : CanCtrlType.Unknown;
        }
    }
}
