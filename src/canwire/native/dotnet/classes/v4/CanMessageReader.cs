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
            message = any ? Received((byte*)&raw) : null;
            return any;
        }

        public int ReadMessages(out ICanMessage[] msgarray)
        {
            return ReadBlock(out msgarray);
        }

        public int ReadMessages(out ICanMessage2[] msgarray)
        {
            return ReadBlock(out msgarray);
        }

        private int ReadBlock<T>(out T[] into) where T : class
        {
            ushort count;
            Alive();
            var at = (byte*)Acquire(out count);
            int size = isLong ? sizeof(CanMsg2) : sizeof(CanMsg);
            into = count > 0 ? new T[count] : null;
            for (int k = 0; k < count; k++, at += size)
                into[k] = (T)(object)Received(at);
            if (count > 0)
                Release(count);
            return count;
        }

        private CanMessageBase Received(byte* from)
        {
            return isLong ? (CanMessageBase)CanValues.Received((CanMsg2*)from) : CanValues.Received((CanMsg*)from);
        }
    }
}
