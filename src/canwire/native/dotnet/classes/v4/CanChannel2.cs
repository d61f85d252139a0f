// A program's queues on a CAN FD line. Source: the vendor's published contract of Ixxat.Vci4.
using Canwire.Native;

namespace Ixxat.Vci4.Bal.Can
{
    internal sealed unsafe class CanChannel2 : CanSocket2, ICanChannel2
    {
        private QueueOwner queues;

        internal CanChannel2(BalResource at) : base(at)
        {
        }

        public CanChannelStatus ChannelStatus
        {
            get
            {
                CanChannelState2 state;
                Check(queues.Queue.Call(QueueSlot.ChannelStatus, &state));
                return new CanChannelStatus(state.Activated != 0, state.Overrun != 0, state.ReceiveLoad, state.TransmitLoad);
            }
        }

        public void Initialize(ushort receiveFifoSize, ushort transmitFifoSize, uint filterSize, CanFilterModes filterMode,
            bool exclusive)
        {
            Check(queues.Prepared(exclusive).Call(
                QueueSlot.Initialize, receiveFifoSize, transmitFifoSize, filterSize, (uint)filterMode));
        }

        public void Activate()
        {
            queues.Activate();
        }

        public void Deactivate()
        {
            queues.Deactivate();
        }

        public ICanMessageReader GetMessageReader()
        {
            return new CanMessageReader(queues.End(QueueSlot.GetReader), true);
        }

        public ICanMessageWriter GetMessageWriter()
        {
            return new CanMessageWriter(queues.End(QueueSlot.GetWriter), true);
        }

        public byte GetFilterMode(CanFilter bSelect)
        {
            byte mode;
            Check(queues.Queue.Call(QueueSlot.GetFilterMode, (uint)bSelect, &mode));
            return mode;
        }

        public byte SetFilterMode(CanFilter bSelect, CanFilterModes bMode)
        {
            byte before;
            Check(queues.Queue.Call(QueueSlot.SetFilterMode, (uint)bSelect, (uint)bMode, &before));
            return before;
        }

        public void SetAccFilter(CanFilter bSelect, uint dwCode, uint dwMask)
        {
            Check(queues.Queue.Call(QueueSlot.SetAccFilter, (uint)bSelect, dwCode, dwMask));
        }

        public void AddFilterIds(CanFilter bSelect, uint dwCode, uint dwMask)
        {
            Check(queues.Queue.Call(QueueSlot.AddFilterIds, (uint)bSelect, dwCode, dwMask));
        }

        public void RemFilterIds(CanFilter bSelect, uint dwCode, uint dwMask)
        {
            Check(queues.Queue.Call(QueueSlot.RemFilterIds, (uint)bSelect, dwCode, dwMask));
        }

        internal override void Open(Place place)
        {
            base.Open(place);
            queues = new QueueOwner(this, Socket);
        }
    }
}
