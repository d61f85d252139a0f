// The cyclic list of a CAN FD line. Source: the vendor's published contract of Ixxat.Vci4; VCI V4 manual 5.2.5.
using Canwire.Native;

namespace Ixxat.Vci4.Bal.Can
{
    internal sealed class CanScheduler2 : CanSocket2, ICanScheduler2
    {
        private CyclicList list;

        internal CanScheduler2(BalResource at) : base(at)
        {
        }

        public void Suspend()
        {
            list.Call(SchedulerSlot.Suspend);
        }

        public void Resume()
        {
            list.Call(SchedulerSlot.Resume);
        }

        public void Reset()
        {
            list.Reset();
        }

        /// <summary>Nothing to do, for Status is always that of now.</summary>
        public void UpdateStatus()
        {
        }

        public ICanCyclicTXMsg2 AddMessage()
        {
            return list.Add();
        }

        internal override void Open(Place place)
        {
            base.Open(place);
            list = new CyclicList(this, Hold(place.Open(Iid.CanScheduler2)), true);
        }
    }
}
