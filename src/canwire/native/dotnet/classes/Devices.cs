// The manager of boards, their list and its enumerators. Source: VCI V3 .NET manual 2.2; contract of Ixxat.Vci4.
using System;
using System.Collections;
using System.Threading;
using Canwire.Native;

#if VCI3
namespace Ixxat.Vci3
#else
namespace Ixxat.Vci4
#endif
{
    internal sealed class VciDeviceManager : Disposable, IVciDeviceManager
    {
        private readonly NativeObject manager;

        internal VciDeviceManager()
        {
            IntPtr made;
            Check(Library.VciGetDeviceManager(out made));
            manager = Hold(made);
        }

        public IVciDeviceList GetDeviceList()
        {
            Alive();
            return new VciDeviceList(Enumerate());
        }

        /// <summary>A new IVciEnumDevice.</summary>
        internal unsafe IntPtr Enumerate()
        {
            IntPtr made;
            Check(manager.Call(DeviceManagerSlot.EnumDevices, &made));
            return made;
        }

        /// <summary>A new IVciDevice.</summary>
        internal unsafe IntPtr Open(long id)
        {
            IntPtr made;
            Check(manager.Call(DeviceManagerSlot.OpenDevice, &id, &made));
            return made;
        }
    }

    internal sealed class VciDeviceList : Disposable, IVciDeviceList
    {
        private readonly Assignment changes;

        internal VciDeviceList(IntPtr devices)
        {
            changes = new Assignment(Hold(devices), EnumDeviceSlot.AssignEvent);
        }

        public void AssignEvent(AutoResetEvent changeEvent)
        {
            Assign(changeEvent);
        }

        public void AssignEvent(ManualResetEvent changeEvent)
        {
            Assign(changeEvent);
        }

        public IEnumerator GetEnumerator()
        {
            Alive();
            using (var manager = new VciDeviceManager())
                return new VciDeviceEnumerator(manager.Enumerate());
        }

        internal override void Ending()
        {
            changes.Dispose();
        }

        private void Assign(EventWaitHandle target)
        {
            Alive();
            Check(changes.Assign(target));
        }
    }

    internal sealed unsafe class VciDeviceEnumerator : Disposable, IEnumerator
    {
        private readonly NativeObject devices;
        private VciDevice current;

        internal VciDeviceEnumerator(IntPtr devices)
        {
            this.devices = Hold(devices);
        }

        public object Current
        {
            get
            {
                Alive();
                if (current == null)
                    throw new InvalidOperationException("the enumerator is before the first board or behind the last one");
                return current;
            }
        }

        public bool MoveNext()
        {
            Alive();
            VciDeviceInfo info;
            uint fetched;
            current = null;
            int result = devices.Call(EnumDeviceSlot.Next, 1, &info, &fetched);
            if (result == Results.NoMoreItems)
                return false;
            Check(result);
            current = new VciDevice(info);
            return true;
        }

        public void Reset()
        {
            Alive();
            current = null;
            Check(devices.Call(EnumDeviceSlot.Reset));
        }
    }
}
