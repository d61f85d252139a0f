// Messages that are received and sent. Source: the vendor's published contract of Ixxat.Vci4.
using Canwire.Native;

namespace Ixxat.Vci4.Bal.Can
{
    internal sealed class CanMessage : CanMessageBase
    {
        internal override bool IsLong
        {
            get { return false; }
        }

        public override bool Equals(object obj)
        {
            return obj is CanMessage && CanValues.Same(this, (CanMessage)obj);
        }

        public override int GetHashCode()
        {
            return (int)Identifier;
        }
    }

    internal sealed class CanMessage2 : CanMessageBase
    {
        internal override bool IsLong
        {
            get { return true; }
        }

        public override bool Equals(object obj)
        {
            return obj is CanMessage2 && CanValues.Same(this, (CanMessage2)obj);
        }

        public override int GetHashCode()
        {
            return (int)Identifier;
        }
    }

    /// <summary>Messages as structures of the one kind or the other, and back.</summary>
    internal static unsafe class CanValues
    {
        internal static bool Same(CanMessageBase one, CanMessageBase other)
        {
            bool same = one.Raw.Time == other.Raw.Time && one.Raw.Identifier == other.Raw.Identifier
                && one.Raw.Info == other.Raw.Info;
            for (int at = 0; same && at < one.Room; at++)
                same = one[at] == other[at];
            return same;
        }

        internal static CanMessage Received(CanMsg* from)
        {
            var made = new CanMessage();
            made.Raw.Time = from->Time;
            made.Raw.Identifier = from->Identifier;
            made.Raw.Info = from->Info;
            fixed (byte* data = made.Raw.Data)
                *(ulong*)data = *(ulong*)from->Data;
            return made;
        }

        internal static CanMessage2 Received(CanMsg2* from)
        {
            return new CanMessage2 { Raw = *from };
        }

        internal static CanMsg Short(CanMsg2 from)
        {
            var made = new CanMsg { Time = from.Time, Identifier = from.Identifier, Info = from.Info };
            *(ulong*)made.Data = *(ulong*)from.Data;
            return made;
        }
    }
}
