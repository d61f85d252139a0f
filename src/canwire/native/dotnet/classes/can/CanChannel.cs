// A program's queues on a CAN line. Source: VCI V3 .NET manual 4.2.3; the contract of Ixxat.Vci4.
using Canwire.Native;

#if VCI3
namespace Ixxat.Vci3.Bal.Can
#else
namespace Ixxat.Vci4.Bal.Can
#endif
{
    internal sealed unsafe class CanChannel : CanSocket, ICanChannel
    {
        private QueueOwner queues;

        internal CanChannel(BalResource at) : base(at)
        {
        }

        public CanChannelStatus ChannelStatus
        {
            get
            {
                CanChannelState state;
                Check(queues.Queue.Call(QueueSlot.ChannelStatus, &state));
                return new CanChannelStatus(state.Activated != 0, state.Overrun != 0, state.ReceiveLoad, state.TransmitLoad);
            }
        }

        public void Initialize(ushort receiveFifoSize, ushort transmitFifoSize, bool exclusive)
        {
            Check(queues.Prepared(exclusive).Call(QueueSlot.Initialize, (uint)receiveFifoSize, (uint)transmitFifoSize));
        }

        public void Activate()
        {
            queues.Activate();
        }

        public void Deactivate()
        {
            queues.Deactivate();
        }

#if VCI3
        public ICanMessageReader GetMessageReader()
        {
            return new CanMessageReader(queues.End(QueueSlot.GetReader));
        }

        public ICanMessageWriter GetMessageWriter()
        {
            return new CanMessageWriter(queues.End(QueueSlot.GetWriter));
        }
#else
        public ICanMessageReader GetMessageReader()
        {
            return new CanMessageReader(queues.End(QueueSlot.GetReader), false);
        }

        public ICanMessageWriter GetMessageWriter()
        {
            return new CanMessageWriter(queues.End(QueueSlot.GetWriter), false);
        }
#endif

        internal override void Open(Place place)
        {
            base.Open(place);
            queues = new QueueOwner(this, Socket);
#if VCI3
            queues.Prepared(false); // refused beside an exclusive channel
#endif
        }
    }
}
