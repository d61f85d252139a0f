// The bit rates that the contract of Ixxat.Vci4 names: rate, ratio of the segments, jump width, delay compensation.
// Source: the vendor's published contract of Ixxat.Vci4 (its names' misprints among them); cantype.h.
namespace Ixxat.Vci4.Bal.Can
{
    public partial struct CanBitrate2
    {
        public static CanBitrate2 Empty
        {
            get { return new CanBitrate2(CanBitrateMode.None, 0, 0, 0, 0, 0, "<Empty>"); }
        }

        public static CanBitrate2 Cia10KBit
        {
            get { return new CanBitrate2(CanBitrateMode.None, 10000, 14, 2, 1, 0, "CiA 10 kbit/s"); }
        }

        public static CanBitrate2 Cia20KBit
        {
            get { return new CanBitrate2(CanBitrateMode.None, 20000, 14, 2, 1, 0, "CiA 20 kbit/s"); }
        }

        public static CanBitrate2 Cia50KBit
        {
            get { return new CanBitrate2(CanBitrateMode.None, 50000, 14, 2, 1, 0, "CiA 50 kbit/s"); }
        }

        public static CanBitrate2 Cia125KBit
        {
            get { return new CanBitrate2(CanBitrateMode.None, 125000, 14, 2, 1, 0, "CiA 125 kbit/s"); }
        }

        public static CanBitrate2 Cia250KBit
        {
            get { return new CanBitrate2(CanBitrateMode.None, 250000, 14, 2, 1, 0, "CiA 250 kbit/s"); }
        }

        public static CanBitrate2 Cia500KBit
        {
            get { return new CanBitrate2(CanBitrateMode.None, 500000, 14, 2, 1, 0, "CiA 500 kbit/s"); }
        }

        public static CanBitrate2 Cia800KBit
        {
            get { return new CanBitrate2(CanBitrateMode.None, 800000, 8, 2, 1, 0, "CiA 800 kbit/s"); }
        }

        public static CanBitrate2 Cia1000KBit
        {
            get { return new CanBitrate2(CanBitrateMode.None, 1000000, 6, 2, 1, 0, "CiA 1000 kbit/s"); }
        }

        public static CanBitrate2 _100KBit
        {
            get { return new CanBitrate2(CanBitrateMode.None, 100000, 14, 2, 1, 0, "100 kbit/s"); }
        }

        public static CanBitrate2 IFI833KBit
        {
            get { return new CanBitrate2(CanBitrateMode.Raw, 6, 12, 3, 3, 78, "IFI CAN-FD 1000 kbit/s"); }
        }

        public static CanBitrate2 IFI1000KBit
        {
            get { return new CanBitrate2(CanBitrateMode.Raw, 4, 15, 4, 4, 64, "IFI CAN-FD 1000 kbit/s"); }
        }

        public static CanBitrate2 IFI2000KBit
        {
            get { return new CanBitrate2(CanBitrateMode.Raw, 2, 15, 4, 4, 32, "IFI CAN-FD 2000 kbit/s"); }
        }

        public static CanBitrate2 IFI4000KBit
        {
            get { return new CanBitrate2(CanBitrateMode.Raw, 2, 7, 2, 2, 16, "IFI CAN-FD 4000 kbit/s"); }
        }

        public static CanBitrate2 IFI5000KBit
        {
            get { return new CanBitrate2(CanBitrateMode.Raw, 2, 5, 2, 2, 12, "IFI CAN-FD 5000 kbit/s"); }
        }

        public static CanBitrate2 IFI6667KBit
        {
            get { return new CanBitrate2(CanBitrateMode.Raw, 2, 3, 2, 2, 8, "IFI CAN-FD 6667 kbit/s"); }
        }

        public static CanBitrate2 IFI8000KBit
        {
            get { return new CanBitrate2(CanBitrateMode.Raw, 2, 3, 1, 1, 5, "IFI CAN-FD 8000 kbit/s"); }
        }

        public static CanBitrate2 IFI10000KBit
        {
            get { return new CanBitrate2(CanBitrateMode.Raw, 2, 2, 1, 1, 4, "IFI CAN-FD 10000 kbit/s"); }
        }

        public static CanBitrate2 CANFD250KBit
        {
            get { return new CanBitrate2(CanBitrateMode.None, 250000, 6400, 1600, 1600, 6400, "CANFD 250 kbit/s"); }
        }

        public static CanBitrate2 CANFD500KBit
        {
            get { return new CanBitrate2(CanBitrateMode.None, 500000, 6400, 1600, 1600, 6400, "CANFD 500 kbit/s"); }
        }

        public static CanBitrate2 CANFD833KBit
        {
            get { return new CanBitrate2(CanBitrateMode.None, 833333, 1600, 400, 400, 6480, "CANFD 833 kbit/s"); }
        }

        public static CanBitrate2 CANFD1000KBit
        {
            get { return new CanBitrate2(CanBitrateMode.None, 1000000, 1600, 400, 400, 1600, "CANFD 1000 kbit/s"); }
        }

        public static CanBitrate2 CANFD1538KBit
        {
            get { return new CanBitrate2(CanBitrateMode.None, 1538461, 1000, 300, 300, 1040, "CANFD 1538 kbit/s"); }
        }

        public static CanBitrate2 CANFD2000KBit
        {
            get { return new CanBitrate2(CanBitrateMode.None, 2000000, 1600, 400, 400, 1600, "CANFD 2000 kbit/s"); }
        }

        public static CanBitrate2 CANFD4000KBit
        {
            get { return new CanBitrate2(CanBitrateMode.None, 4000000, 800, 200, 200, 800, "CANFD 4000 kbit/s"); }
        }

        public static CanBitrate2 CANFD5000KBit
        {
            get { return new CanBitrate2(CanBitrateMode.None, 5000000, 600, 200, 200, 600, "CANFD 5000 kbit/s"); }
        }

        public static CanBitrate2 CANFD6667KBit
        {
            get { return new CanBitrate2(CanBitrateMode.None, 6666666, 400, 200, 200, 402, "CANFD 6667 kbit/s"); }
        }

        public static CanBitrate2 CANFD8000KBit
        {
            get { return new CanBitrate2(CanBitrateMode.None, 8000000, 400, 100, 100, 250, "CANFD 8000 kbit/s"); }
        }

        public static CanBitrate2 CANFD10000KBit
        {
            get { return new CanBitrate2(CanBitrateMode.None, 10000000, 300, 100, 100, 200, "CANFD 10000 kbit/s"); }
        }

        public static CanBitrate2 CANopenArb1000KBit
        {
            get { return new CanBitrate2(CanBitrateMode.None, 1000000, 800, 200, 200, 0, "CANopen 1000 kbit/s"); }
        }

        public static CanBitrate2 CANopenArb800KBit
        {
            get { return new CanBitrate2(CanBitrateMode.None, 800000, 800, 200, 200, 0, "CANopen 800 kbit/s"); }
        }

        public static CanBitrate2 CANopenArb500KBit
        {
            get { return new CanBitrate2(CanBitrateMode.None, 500000, 800, 200, 200, 0, "CANopen 500 kbit/s"); }
        }

        public static CanBitrate2 CANopenArb250KBit
        {
            get { return new CanBitrate2(CanBitrateMode.None, 250000, 800, 200, 200, 0, "CANopen 250 kbit/s"); }
        }

        public static CanBitrate2 CANopenArb125KBit
        {
            get { return new CanBitrate2(CanBitrateMode.None, 125000, 800, 200, 200, 0, "CANopen 125 kbit/s"); }
        }

        public static CanBitrate2 CANopen1000KBit
        {
            get { return new CanBitrate2(CanBitrateMode.None, 1000000, 800, 200, 200, 750, "CANopen 10000 kbit/s"); }
        }

        public static CanBitrate2 CANopen2000KBit
        {
            get { return new CanBitrate2(CanBitrateMode.None, 2000000, 750, 250, 250, 770, "CANopen 20000 kbit/s"); }
        }

        public static CanBitrate2 CANopen4000KBit
        {
            get { return new CanBitrate2(CanBitrateMode.None, 4000000, 700, 300, 300, 600, "CANopen 4000 kbit/s"); }
        }

        public static CanBitrate2 CANopen5000KBit
        {
            get { return new CanBitrate2(CanBitrateMode.None, 5000000, 750, 250, 250, 750, "CANopen 5000 kbit/s"); }
        }

        public static CanBitrate2[] CanFdIFIBitRates
        {
            get
            {
                return new[] {
                    IFI1000KBit, IFI2000KBit, IFI4000KBit, IFI5000KBit, IFI6667KBit, IFI8000KBit, IFI10000KBit
                };
            }
        }

        public static CanBitrate2[] CanFdBitRates
        {
            get
            {
                return new[] {
                    CANFD1000KBit, CANFD2000KBit, CANFD4000KBit, CANFD5000KBit, CANFD6667KBit, CANFD8000KBit,
                    CANFD10000KBit
                };
            }
        }

        public static CanBitrate2[] CiaBitRates
        {
            get
            {
                return new[] {
                    Cia10KBit, Cia20KBit, Cia50KBit, Cia125KBit, Cia250KBit, Cia500KBit, Cia800KBit, Cia1000KBit
                };
            }
        }
    }
}
