// LIN messages. Source: VCI V3 .NET manual 4.3.3.1, 4.3.4.2; the vendor's published contract of Ixxat.Vci4.
using System;
using System.Text;
using Canwire.Native;

#if VCI3
namespace Ixxat.Vci3.Bal.Lin
#else
namespace Ixxat.Vci4.Bal.Lin
#endif
{
    /// <summary>A LIN message of up to 8 bytes; a new one is a data message of no bytes.</summary>
#if VCI3
    public unsafe struct LinMessage
#else
    internal sealed unsafe class LinMessage : ILinMessage
#endif
    {
        private const byte Enhanced = 1, Own = 2, Overrun = 4, HeaderOnly = 8;

        internal LinMsg Raw;

        public uint TimeStamp
        {
            get { return Raw.Time; }
            set { Raw.Time = value; }
        }

        public byte ProtId
        {
            get { return Raw.ProtId; }
            set { Raw.ProtId = value; }
        }

        public LinMessageType MessageType
        {
            get { return (LinMessageType)Raw.Type; }
            set { Raw.Type = (byte)value; }
        }

        public byte DataLength
        {
            get { return Raw.Length; }
            set
            {
                if (value > LinMsg.Bytes)
                    throw new ArgumentOutOfRangeException("length", value, "a LIN message has up to 8 bytes");
                Raw.Length = value;
            }
        }

        public bool PossibleOverrun
        {
            get { return (Raw.Flags & Overrun) != 0; }
        }

        public bool ExtendedCrc
        {
            get { return (Raw.Flags & Enhanced) != 0; }
            set { Mark(Enhanced, value); }
        }

        public bool SenderOfResponse
        {
            get { return (Raw.Flags & Own) != 0; }
            set { Mark(Own, value); }
        }

        public bool IdOnly
        {
            get { return (Raw.Flags & HeaderOnly) != 0; }
            set { Mark(HeaderOnly, value); }
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
            Raw = new LinMsg();
        }

        public override bool Equals(object obj)
        {
            if (!(obj is LinMessage))
                return false;
            LinMsg other = ((LinMessage)obj).Raw, own = Raw;
            for (int at = 0; at < sizeof(LinMsg); at++)
                if (((byte*)&own)[at] != ((byte*)&other)[at])
                    return false;
            return true;
        }

        public override int GetHashCode()
        {
            return ProtId;
        }

        public override string ToString()
        {
            switch (MessageType)
            {
                case LinMessageType.Data:
                    return DataText();
                case LinMessageType.Info:
                    return string.Format("{0} : Info {1}", TimeStamp, (LinMsgInfoValue)this[0]);
                case LinMessageType.Error:
                    return string.Format("{0} : Error {1}", TimeStamp, (LinMsgError)this[0]);
                case LinMessageType.Status:
                    return string.Format("{0} : Status {1}", TimeStamp, (LinCtrlStatus)this[0]);
                case LinMessageType.TimeOverrun:
                    return string.Format("{0} : TimeOverrun : Count={1}", TimeStamp, DataLength);
                default:
                    return string.Format("{0} : {1}", TimeStamp, MessageType);
            }
        }

        private string DataText()
        {
            var text = new StringBuilder();
            text.AppendFormat("{0} : Data [{1:D3}]", TimeStamp, ProtId);
            for (int at = 0; at < Math.Min(DataLength, (byte)LinMsg.Bytes); at++)
                text.AppendFormat(" {0:X2}", this[at]);
            return text.ToString();
        }

        private void Mark(byte bit, bool set)
        {
            Raw.Flags = (byte)(set ? Raw.Flags | bit : Raw.Flags & ~bit);
        }

        private static void Check(int index)
        {
            if (index < 0 || index >= LinMsg.Bytes)
                throw new ArgumentOutOfRangeException("index", index, "a LIN message has bytes 0 to 7");
        }
    }
}
