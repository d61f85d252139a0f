// The writing end of a channel. Source: the vendor's published contract of Ixxat.Vci4.
using System;
using Canwire.Native;

namespace Ixxat.Vci4.Bal.Can
{
    /// <summary>Takes messages of both kinds; an ICanChannel's no more than 8 bytes and no CAN FD.</summary>
    internal sealed unsafe class CanMessageWriter : FifoEnd, ICanMessageWriter
    {
        private readonly bool isLong;

        internal CanMessageWriter(IntPtr writer, bool isLong) : base(writer)
        {
            this.isLong = isLong;
        }

        public ushort FreeCount
        {
            get { return Count(FifoSlot.GetFreeCount); }
        }

        public bool SendMessage(ICanMessage message)
        {
            Alive();
            var known = message as CanMessageBase;
            if (known == null)
                throw new ArgumentException("a message of MsgFactory.CreateMsg belongs here, not " + (message ?? (object)"null"), "message");
            CanMsg2 raw = known.Raw;
            if (isLong)
                return Put(&raw);
            if ((raw.Info & Info.LongData) != 0)
                throw new ArgumentException("an ICanChannel sends no CAN FD messages; an ICanChannel2 does", "message");
            CanMsg one = CanValues.Short(raw);
            return Put(&one);
        }

        public bool SendMessage(ICanMessage2 message)
        {
            return SendMessage((ICanMessage)message);
        }
    }
}
