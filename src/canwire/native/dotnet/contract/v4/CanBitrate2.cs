// Bit rates of CAN FD lines. Source: the vendor's published contract of Ixxat.Vci4; VCI V4 manual 7.3.1.
using System;
using System.Linq;

namespace Ixxat.Vci4.Bal.Can
{
    /// <summary>What the figures of a CanBitrate2 are: bit/s and ratios, or with Raw prescaler and quanta.</summary>
    [Flags]
    public enum CanBitrateMode : int
    {
        None = 0x0,
        Raw = 0x00000001,
        TripleSampling = 0x00000002
    }

    /// <summary>One bit rate of a CAN FD line, with a name that does not count.</summary>
    public partial struct CanBitrate2
    {
        private readonly CanBitrateMode mode;
        private readonly uint prescaler;
        private readonly ushort timeSegment1;
        private readonly ushort timeSegment2;
        private readonly ushort sjw;
        private readonly ushort delay;
        private readonly string name;

        public CanBitrate2(CanBitrateMode BittimingMode, uint Prescaler, ushort TimeSegment1, ushort TimeSegment2,
            ushort Sjw, ushort TranmitterDelay)
            : this(BittimingMode, Prescaler, TimeSegment1, TimeSegment2, Sjw, TranmitterDelay, null)
        {
        }

        public CanBitrate2(CanBitrateMode BittimingMode, uint Prescaler, ushort TimeSegment1, ushort TimeSegment2,
            ushort Sjw, ushort TranmitterDelay, string name)
        {
            mode = BittimingMode;
            prescaler = Prescaler;
            timeSegment1 = TimeSegment1;
            timeSegment2 = TimeSegment2;
            sjw = Sjw;
            delay = TranmitterDelay;
            this.name = name;
        }

        public CanBitrateMode Mode
        {
            get { return mode; }
        }

        /// <summary>Bit/s, or with Raw the prescaler.</summary>
        public uint Prescaler
        {
            get { return prescaler; }
        }

        public ushort TimeSegment1
        {
            get { return timeSegment1; }
        }

        public ushort TimeSegment2
        {
            get { return timeSegment2; }
        }

        public ushort Sjw
        {
            get { return sjw; }
        }

        public ushort TransmitterDelay
        {
            get { return delay; }
        }

        /// <summary>0, as the vendor's.</summary>
        public int Bittime
        {
            get { return 0; }
        }

        public string Name
        {
            get { return ToString(); }
        }

        public override string ToString()
        {
            return name ?? "not specified";
        }

        public override bool Equals(object obj)
        {
            return obj is CanBitrate2 && Equals((CanBitrate2)obj);
        }

        public bool Equals(CanBitrate2 other)
        {
            return mode == other.mode && prescaler == other.prescaler && timeSegment1 == other.timeSegment1
                && timeSegment2 == other.timeSegment2 && sjw == other.sjw && delay == other.delay;
        }

        public override int GetHashCode()
        {
            return (int)((uint)mode + prescaler + timeSegment1 + timeSegment2 + sjw + delay);
        }

        public static bool operator ==(CanBitrate2 lhs, CanBitrate2 rhs)
        {
            return lhs.Equals(rhs);
        }

        public static bool operator !=(CanBitrate2 lhs, CanBitrate2 rhs)
        {
            return !lhs.Equals(rhs);
        }
    }

    /// <summary>Both bit rates of a CAN FD line, as DetectBaud takes them.</summary>
    public struct CanFdBitrate
    {
        private readonly CanBitrate2 standard;
        private readonly CanBitrate2 fast;

        public CanFdBitrate(CanBitrate2 stdBitrate, CanBitrate2 fastBitrate)
        {
            standard = stdBitrate;
            fast = fastBitrate;
        }

        public CanFdBitrate(CanBitrate2 bitrate) : this(bitrate, bitrate)
        {
        }

        public CanBitrate2 StdBitrate
        {
            get { return standard; }
        }

        public CanBitrate2 FastBitrate
        {
            get { return fast; }
        }

        public static CanFdBitrate[] CiaBitRates
        {
            get { return CanBitrate2.CiaBitRates.Select(one => new CanFdBitrate(one)).ToArray(); }
        }

        public static CanFdBitrate[] ShortLineCANFDBitRates
        {
            get { return Pairs(new[] { CanBitrate2.CANFD500KBit }, CanBitrate2.CanFdBitRates); }
        }

        public static CanFdBitrate[] LongLineCANFDBitRates
        {
            get
            {
                return Pairs(new[] { CanBitrate2.CANFD250KBit }, new[] {
                    CanBitrate2.CANFD500KBit, CanBitrate2.CANFD833KBit, CanBitrate2.CANFD1000KBit,
                    CanBitrate2.CANFD1538KBit, CanBitrate2.CANFD2000KBit, CanBitrate2.CANFD4000KBit
                });
            }
        }

        public static CanFdBitrate[] CANopenBitRates
        {
            get
            {
                return Pairs(new[] {
                    CanBitrate2.CANopenArb125KBit, CanBitrate2.CANopenArb250KBit, CanBitrate2.CANopenArb500KBit,
                    CanBitrate2.CANopenArb800KBit, CanBitrate2.CANopenArb1000KBit
                }, new[] {
                    CanBitrate2.CANopen1000KBit, CanBitrate2.CANopen2000KBit, CanBitrate2.CANopen4000KBit,
                    CanBitrate2.CANopen5000KBit
                });
            }
        }

        private static CanFdBitrate[] Pairs(CanBitrate2[] standard, CanBitrate2[] fast)
        {
            return standard.SelectMany(one => fast.Select(other => new CanFdBitrate(one, other))).ToArray();
        }
    }
}
