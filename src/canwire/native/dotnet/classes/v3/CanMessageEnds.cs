// Both ends of a channel. Source: VCI V3 .NET manual 3.1, 4.2.3.1, 4.2.3.2.
using System;
using Canwire.Native;

namespace Ixxat.Vci3.Bal.Can
{
    internal sealed unsafe class CanMessageReader : FifoEnd, ICanMessageReader
    {
        internal CanMessageReader(IntPtr reader) : base(reader)
        {
        }

        public ushort FillCount
        {
            get { return Count(FifoSlot.GetFillCount); }
        }

        public bool ReadMessage(out CanMessage message)
        {
            CanMsg raw;
            Alive();
            bool any = Take(&raw);
            message = any ? CanMessage.Received(raw) : new CanMessage();
            return any;
        }

        public int ReadMessages(CanMessage[] messages)
        {
            int done = 0;
            lock (Gate)
            {
                Alive();
                while (done < messages.Length)
                {
                    ushort there;
                    var at = (CanMsg*)Acquire(out there);
                    int count = Math.Min((int)there, messages.Length - done);
                    if (count == 0)
                        break;
                    for (int k = 0; k < count; k++)
                        messages[done++] = CanMessage.Received(at[k]);
                    Release((ushort)count);
                }
            }
            return done;
        }

        public bool GetMessage(out CanMessage message)
        {
            return ReadMessage(out message);
        }

        public int GetMessages(CanMessage[] messages)
        {
            return ReadMessages(messages);
        }
    }

    internal sealed unsafe class CanMessageWriter : FifoEnd, ICanMessageWriter
    {
        internal CanMessageWriter(IntPtr writer) : base(writer)
        {
        }

        public ushort FreeCount
        {
            get { return Count(FifoSlot.GetFreeCount); }
        }

        public bool SendMessage(CanMessage message)
        {
            CanMsg raw = message.Raw;
            Alive();
            return Put(&raw);
        }

        public int SendMessages(CanMessage[] messages)
        {
            int done = 0;
            Alive();
            while (done < messages.Length && SendMessage(messages[done]))
                done++;
            return done;
        }

        public bool WriteMessage(CanMessage message)
        {
            return SendMessage(message);
        }

        public int WriteMessages(CanMessage[] messages)
        {
            return SendMessages(messages);
        }
    }
}
