// The reading end of a channel. Source: the vendor's published contract of Ixxat.Vci4.
using System;
using Canwire.Native;

namespace Ixxat.Vci4.Bal.Can
{
    /// <summary>Gives CanMessage of an ICanChannel, CanMessage2 of an ICanChannel2.</summary>
    internal sealed unsafe class CanMessageReader : FifoEnd, ICanMessageReader
    {
        private readonly bool isLong;

        internal CanMessageReader(IntPtr reader, bool isLong) : base(reader)
        {
            this.isLong = isLong;
        }

        public ushort FillCount
        {
            get { return Count(FifoSlot.GetFillCount); }
        }

        public bool ReadMessage(out ICanMessage message)
        {
            ICanMessage2 read;
            bool any = ReadMessage(out read);
            message = read;
            return any;
        }

        public bool ReadMessage(out ICanMessage2 message)
        {
            CanMsg2 raw; // CANMSG is shorter
            Alive();
            bool any = Take(&raw);
            message = !any ? null : isLong ? CanValues.Received(&raw) : (CanMessageBase)CanValues.Received((CanMsg*)&raw);
            return any;
        }

        public int ReadMessages(out ICanMessage[] msgarray)
        {
            msgarray = ReadBlock();
            return msgarray == null ? 0 : msgarray.Length;
        }

        public int ReadMessages(out ICanMessage2[] msgarray)
        {
            msgarray = ReadBlock();
            return msgarray == null ? 0 : msgarray.Length;
        }

        /// <summary>Null if there are none.</summary>
        private ICanMessage2[] ReadBlock()
        {
            lock (Gate)
            {
                ushort count;
                Alive();
                void* from = Acquire(out count);
                if (count == 0)
                    return null;
                ICanMessage2[] made = isLong ? LongOnes((CanMsg2*)from, count) : ShortOnes((CanMsg*)from, count);
                Release(count);
                return made;
            }
        }

        // arrays of the classes themselves, into which Mono stores without a look at interfaces

        private static ICanMessage2[] LongOnes(CanMsg2* from, int count)
        {
            var made = new CanMessage2[count];
            for (int at = 0; at < count; at++)
                made[at] = CanValues.Received(from + at);
            return made;
        }

        private static ICanMessage2[] ShortOnes(CanMsg* from, int count)
        {
            var made = new CanMessage[count];
            for (int at = 0; at < count; at++)
                made[at] = CanValues.Received(from + at);
            return made;
        }
    }
}
