// Bit rates as an SJA1000 takes them. Source: VCI V3 .NET manual 4.2.4.1; the contract of Ixxat.Vci4.
#if VCI3
namespace Ixxat.Vci3.Bal.Can
#else
namespace Ixxat.Vci4.Bal.Can
#endif
{
    /// <summary>Registers BTR0 and BTR1 of an SJA1000 at 16 MHz, with a name that does not count.</summary>
    public struct CanBitrate
    {
        private readonly byte btr0;
        private readonly byte btr1;
        private readonly string name;

        public CanBitrate(byte bitTimingRegister0, byte bitTimingRegister1) : this(bitTimingRegister0, bitTimingRegister1, null)
        {
        }

        public CanBitrate(byte bitTimingRegister0, byte bitTimingRegister1, string name)
        {
            btr0 = bitTimingRegister0;
            btr1 = bitTimingRegister1;
            this.name = name;
        }

        public byte Btr0
        {
            get { return btr0; }
        }

        public byte Btr1
        {
            get { return btr1; }
        }

        /// <summary>BTR1 in the high byte, BTR0 in the low one.</summary>
        public short AsInt16
        {
            get { return (short)(btr1 << 8 | btr0); }
        }

        /// <summary>Clocks of the 16 MHz in a bit.</summary>
        public int Bittime
        {
            get { return 2 * ((btr0 & 0x3F) + 1) * ((btr1 & 0x0F) + (btr1 >> 4 & 0x07) + 3); }
        }

        public string Name
        {
            get { return ToString(); }
        }

        public static CanBitrate Empty
        {
            get { return new CanBitrate(0, 0, "<Empty>"); }
        }

        public static CanBitrate Cia10KBit
        {
            get { return new CanBitrate(0x31, 0x1C, "CiA 10 kbit/s"); }
        }

        public static CanBitrate Cia20KBit
        {
            get { return new CanBitrate(0x18, 0x1C, "CiA 20 kbit/s"); }
        }

        public static CanBitrate Cia50KBit
        {
            get { return new CanBitrate(0x09, 0x1C, "CiA 50 kbit/s"); }
        }

        public static CanBitrate Cia125KBit
        {
            get { return new CanBitrate(0x03, 0x1C, "CiA 125 kbit/s"); }
        }

        public static CanBitrate Cia250KBit
        {
            get { return new CanBitrate(0x01, 0x1C, "CiA 250 kbit/s"); }
        }

        public static CanBitrate Cia500KBit
        {
            get { return new CanBitrate(0x00, 0x1C, "CiA 500 kbit/s"); }
        }

        public static CanBitrate Cia800KBit
        {
            get { return new CanBitrate(0x00, 0x16, "CiA 800 kbit/s"); }
        }

        public static CanBitrate Cia1000KBit
        {
            get { return new CanBitrate(0x00, 0x14, "CiA 1000 kbit/s"); }
        }

        public static CanBitrate _100KBit
        {
            get { return new CanBitrate(0x04, 0x1C, "100 kbit/s"); }
        }

        /// <summary>What DetectBaud takes to find one of CiA's.</summary>
        public static CanBitrate[] CiaBitRates
        {
            get
            {
                return new[] {
                    Cia10KBit, Cia20KBit, Cia50KBit, Cia125KBit, Cia250KBit, Cia500KBit, Cia800KBit, Cia1000KBit
                };
            }
        }

        public override string ToString()
        {
            return name ?? string.Format("{0:X2}:{1:X2}", btr0, btr1);
        }

        public override bool Equals(object obj)
        {
            return obj is CanBitrate && Equals((CanBitrate)obj);
        }

        public bool Equals(CanBitrate other)
        {
            return AsInt16 == other.AsInt16;
        }

        public override int GetHashCode()
        {
            return btr0 << 8 | btr1;
        }

        public static bool operator ==(CanBitrate lhs, CanBitrate rhs)
        {
            return lhs.Equals(rhs);
        }

        public static bool operator !=(CanBitrate lhs, CanBitrate rhs)
        {
            return !lhs.Equals(rhs);
        }
    }
}
