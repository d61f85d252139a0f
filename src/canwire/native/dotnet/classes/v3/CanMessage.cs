// Messages that are received and sent. Source: VCI V3 .NET manual 4.2.3.
using System;
using Canwire.Native;

namespace Ixxat.Vci3.Bal.Can
{
    /// <summary>A message of up to 8 bytes, a value as the manual's listings have it; a new one is a data message of no bytes.</summary>
    public unsafe struct CanMessage
    {
        internal CanMsg Raw;

        public uint TimeStamp
        {
            get { return Raw.Time; }
            set { Raw.Time = value; }
        }

        public uint Identifier
        {
            get { return Raw.Identifier; }
            set { Raw.Identifier = value; }
        }

        public CanMsgFrameType FrameType
        {
            get { return (CanMsgFrameType)Info.Type(Raw.Info); }
            set { Raw.Info = Info.WithType(Raw.Info, (uint)value); }
        }

        public CanMsgAccReason AcceptReason
        {
            get { return (CanMsgAccReason)Info.Accepted(Raw.Info); }
        }

        public byte DataLength
        {
            get { return (byte)Info.Code(Raw.Info); }
            set
            {
                if (value > CanMsg.Bytes)
                    throw new ArgumentOutOfRangeException("length", value, "a message has up to 8 bytes");
                Raw.Info = Info.WithCode(Raw.Info, value);
            }
        }

        public bool PossibleOverrun
        {
            get { return (Raw.Info & Info.Overrun) != 0; }
        }

        public bool SelfReceptionRequest
        {
            get { return (Raw.Info & Info.SelfReception) != 0; }
            set { Raw.Info = Info.With(Raw.Info, Info.SelfReception, value); }
        }

        public bool RemoteTransmissionRequest
        {
            get { return (Raw.Info & Info.Remote) != 0; }
            set { Raw.Info = Info.With(Raw.Info, Info.Remote, value); }
        }

        public bool ExtendedFrameFormat
        {
            get { return (Raw.Info & Info.Extended) != 0; }
            set { Raw.Info = Info.With(Raw.Info, Info.Extended, value); }
        }

        public bool SingleShotMode
        {
            get { return (Raw.Info & Info.SingleShot) != 0; }
            set { Raw.Info = Info.With(Raw.Info, Info.SingleShot, value); }
        }

        public bool HighPriorityMsg
        {
            get { return (Raw.Info & Info.HighPriority) != 0; }
            set { Raw.Info = Info.With(Raw.Info, Info.HighPriority, value); }
        }

        public byte this[int index]
        {
            get
            {
                Check(index);
                fixed (byte* data = Raw.Data)
                    return data[index];
            }
            set
            {
                Check(index);
                fixed (byte* data = Raw.Data)
                    data[index] = value;
            }
        }

        public void Clear()
        {
            Raw = new CanMsg();
        }

        public override string ToString()
        {
            var data = new byte[Math.Min((int)DataLength, CanMsg.Bytes)];
            for (int at = 0; at < data.Length; at++)
                data[at] = this[at];
            var raw = new CanMsg2 { Time = Raw.Time, Identifier = Raw.Identifier, Info = Raw.Info };
            return CanText.Of(raw, this[0], data);
        }

        /// <summary>As V3 has it: errors that it has no name for are Other, a bit error at the fast rate is Bit.</summary>
        internal static CanMessage Received(CanMsg from)
        {
            const byte fastBit = 5;
            if (Info.Type(from.Info) == (uint)CanMsgFrameType.Error && !Enum.IsDefined(typeof(CanMsgError), (int)from.Data[0]))
                from.Data[0] = (byte)(from.Data[0] == fastBit ? CanMsgError.Bit : CanMsgError.Other);
            return new CanMessage { Raw = from };
        }

        private static void Check(int index)
        {
            if (index < 0 || index >= CanMsg.Bytes)
                throw new ArgumentOutOfRangeException("index", index, "a message has bytes 0 to 7");
        }
    }
}
