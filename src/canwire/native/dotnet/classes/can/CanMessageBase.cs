// What messages of every kind have. Source: VCI V3 .NET manual 4.2.3.2; the contract of Ixxat.Vci4.
using System;
using System.Text;
using Canwire.Native;

#if VCI3
namespace Ixxat.Vci3.Bal.Can
#else
namespace Ixxat.Vci4.Bal.Can
#endif
{
    /// <summary>A message: VCI's structure, whose bits are properties. A new one is a data message of no bytes.</summary>
#if VCI3
    public abstract unsafe class CanMessageBase
#else
    internal abstract unsafe class CanMessageBase : ICanMessage2
#endif
    {
        internal CanMsg2 Raw;

        internal CanMessageBase()
        {
        }

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
            get { return IsLong ? Info.Length(Info.Code(Raw.Info)) : (byte)Info.Code(Raw.Info); }
            set
            {
                if (value > Room)
                    throw new ArgumentOutOfRangeException("length", value, "a message here has up to " + Room + " bytes");
                Raw.Info = Info.WithCode(Raw.Info, IsLong ? Info.CodeOf(value) : value);
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

#if !VCI3
        public bool ExtendedDataLength
        {
            get { return (Raw.Info & Info.LongData) != 0; }
            set { Raw.Info = Info.With(Raw.Info, Info.LongData, value); }
        }

        public bool FastDataRate
        {
            get { return (Raw.Info & Info.FastData) != 0; }
            set { Raw.Info = Info.With(Raw.Info, Info.FastData, value); }
        }

        public bool ErrorStateIndicator
        {
            get { return (Raw.Info & Info.ErrorState) != 0; }
            set { Raw.Info = Info.With(Raw.Info, Info.ErrorState, value); }
        }
#endif

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

        public virtual void Clear()
        {
            Raw = new CanMsg2();
        }

        public override string ToString()
        {
            return CanText.Of(Raw, this[0], DataBytes());
        }

        internal abstract bool IsLong { get; }

        internal int Room
        {
            get { return IsLong ? CanMsg2.Bytes : CanMsg.Bytes; }
        }

        /// <summary>The bytes that DataLength says there are.</summary>
        internal byte[] DataBytes()
        {
            var made = new byte[Math.Min(DataLength, Room)];
            for (int at = 0; at < made.Length; at++)
                made[at] = this[at];
            return made;
        }

        private void Check(int index)
        {
            if (index < 0 || index >= Room)
                throw new ArgumentOutOfRangeException("index", index, "a message here has bytes 0 to " + (Room - 1));
        }
    }

    /// <summary>Messages as text, as the vendor's print themselves.</summary>
    internal static class CanText
    {
        internal static string Of(CanMsg2 raw, byte first, byte[] data)
        {
            switch ((CanMsgFrameType)Info.Type(raw.Info))
            {
                case CanMsgFrameType.Data:
                    return DataText(raw, data);
                case CanMsgFrameType.Info:
                    return string.Format("{0} : Info {1}", raw.Time, (CanMsgInfoValue)first);
                case CanMsgFrameType.Error:
                    return string.Format("{0} : Error {1}", raw.Time, (CanMsgError)first);
                case CanMsgFrameType.Status:
                    return string.Format("{0} : Status {1}", raw.Time, (CanCtrlStatus)first);
                case CanMsgFrameType.TimeReset:
                    return string.Format("{0} : TimeReset", raw.Time);
                case CanMsgFrameType.TimeOverrun:
                    return string.Format("{0} : TimeOverrun : Count={1}", raw.Time, raw.Identifier);
                case CanMsgFrameType.Wakeup:
                    return string.Format("{0} : Wakeup", raw.Time);
                default:
                    return string.Format("{0} : Type {1}", raw.Time, Info.Type(raw.Info));
            }
        }

        private static string DataText(CanMsg2 raw, byte[] data)
        {
            bool remote = (raw.Info & Info.Remote) != 0;
            var text = new StringBuilder();
            text.AppendFormat("{0} : {1} [{2:D3}] Dlc={3}", raw.Time, remote ? "RTR" : "Data", raw.Identifier, Info.Code(raw.Info));
            if (!remote)
                foreach (byte one in data)
                    text.AppendFormat(" {0:X2}", one);
            return text.ToString();
        }
    }
}
