// Bit rates of LIN. Source: VCI V3 .NET manual 4.3.4.1; the vendor's published contract of Ixxat.Vci4.

#if VCI3
namespace Ixxat.Vci3.Bal.Lin
#else
namespace Ixxat.Vci4.Bal.Lin
#endif
{
    /// <summary>Bits per second, with a name that does not count.</summary>
    public struct LinBitrate
    {
        private readonly ushort bitrate;
        private readonly string name;

        public LinBitrate(ushort bitrate) : this(bitrate, null)
        {
        }

        public LinBitrate(ushort bitrate, string name)
        {
            this.bitrate = bitrate;
            this.name = name;
        }

        public ushort AsUInt16
        {
            get { return bitrate; }
        }

        public string Name
        {
            get { return ToString(); }
        }

        public static LinBitrate Undefined
        {
            get { return new LinBitrate(65535, "Undefined"); }
        }

        public static LinBitrate AutoRate
        {
            get { return new LinBitrate(0, "Automatic"); }
        }

        public static LinBitrate MinBitrate
        {
            get { return new LinBitrate(1000, "Lowest"); }
        }

        public static LinBitrate MaxBitrate
        {
            get { return new LinBitrate(20000, "Highest"); }
        }

        public static LinBitrate Lin1000Bit
        {
            get { return new LinBitrate(1000); }
        }

        public static LinBitrate Lin1200Bit
        {
            get { return new LinBitrate(1200); }
        }

        public static LinBitrate Lin2400Bit
        {
            get { return new LinBitrate(2400); }
        }

        public static LinBitrate Lin4800Bit
        {
            get { return new LinBitrate(4800); }
        }

        public static LinBitrate Lin9600Bit
        {
            get { return new LinBitrate(9600); }
        }

        public static LinBitrate Lin10400Bit
        {
            get { return new LinBitrate(10400); }
        }

        public static LinBitrate Lin19200Bit
        {
            get { return new LinBitrate(19200); }
        }

        public static LinBitrate Lin20000Bit
        {
            get { return new LinBitrate(20000); }
        }

        public override string ToString()
        {
            return name ?? string.Format("{0} bit/s", bitrate);
        }

        public override bool Equals(object obj)
        {
            return obj is LinBitrate && Equals((LinBitrate)obj);
        }

        public bool Equals(LinBitrate other)
        {
            return bitrate == other.bitrate;
        }

        public override int GetHashCode()
        {
            return bitrate;
        }

        public static bool operator ==(LinBitrate lhs, LinBitrate rhs)
        {
            return lhs.Equals(rhs);
        }

        public static bool operator !=(LinBitrate lhs, LinBitrate rhs)
        {
            return !lhs.Equals(rhs);
        }
    }
}
