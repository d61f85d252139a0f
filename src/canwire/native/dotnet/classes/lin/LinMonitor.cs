// A program's own receive FIFO on a LIN line. Source: VCI V3 .NET manual 4.3.3; the contract of Ixxat.Vci4.
using System;
using Canwire.Native;

#if VCI3
namespace Ixxat.Vci3.Bal.Lin
#else
namespace Ixxat.Vci4.Bal.Lin
#endif
{
    internal sealed unsafe class LinMonitor : LinSocket, ILinMonitor
    {
        private QueueOwner queues;

        internal LinMonitor(BalResource at) : base(at)
        {
        }

        public LinMonitorStatus MonitorStatus
        {
            get
            {
                LinMonitorState state;
                Check(queues.Queue.Call(QueueSlot.MonitorStatus, &state));
                return new LinMonitorStatus(state.Activated != 0, state.Overrun != 0, state.ReceiveLoad);
            }
        }

        public ILinMessageReader GetMessageReader()
        {
            return new LinMessageReader(queues.End(QueueSlot.GetReader));
        }

        public void Initialize(ushort receiveFifoSize, bool exclusive)
        {
            Check(queues.Prepared(exclusive).Call(QueueSlot.Initialize, receiveFifoSize));
        }

        public void Activate()
        {
            queues.Activate();
        }

        public void Deactivate()
        {
            queues.Deactivate();
        }

        internal override void Open(Place place)
        {
            base.Open(place);
            queues = new QueueOwner(this, Socket);
#if VCI3
            queues.Prepared(false); // refused beside an exclusive monitor
#endif
        }
    }

    internal sealed unsafe class LinMessageReader : FifoEnd, ILinMessageReader
    {
        internal LinMessageReader(IntPtr reader) : base(reader)
        {
        }

        public ushort FillCount
        {
            get { return Count(FifoSlot.GetFillCount); }
        }

#if VCI3
        public bool ReadMessage(out LinMessage message)
        {
            LinMsg raw;
            Alive();
            bool any = Take(&raw);
            message = any ? new LinMessage { Raw = raw } : new LinMessage();
            return any;
        }

        public int ReadMessages(LinMessage[] messages)
        {
            int count = 0;
            while (count < messages.Length && ReadMessage(out messages[count]))
                count++;
            return count;
        }
#else
        public bool ReadMessage(out ILinMessage message)
        {
            LinMsg raw;
            Alive();
            bool any = Take(&raw);
            message = any ? new LinMessage { Raw = raw } : null;
            return any;
        }

        public int ReadMessages(out ILinMessage[] msgarray)
        {
            lock (Gate)
            {
                ushort count;
                Alive();
                var at = (LinMsg*)Acquire(out count);
                msgarray = count > 0 ? new ILinMessage[count] : null;
                for (int k = 0; k < count; k++)
                    msgarray[k] = new LinMessage { Raw = at[k] };
                if (count > 0)
                    Release(count);
                return count;
            }
        }
#endif
    }
}
