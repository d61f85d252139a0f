// What sets a CAN FD line up. Source: the vendor's published contract of Ixxat.Vci4; VCI V4 manual 5.2.3.
using System;
using Canwire.Native;

namespace Ixxat.Vci4.Bal.Can
{
    internal sealed unsafe class CanControl2 : CanSocket2, ICanControl2
    {
        private const int Pairs = 64; // CAN_BTP_TABLE_SIZE
        private const byte Detecting = 0x20; // CAN_OPMODE_AUTOBAUD
        private const uint StandardIds = 2048, ExtendedIds = 2048; // CAN_FILTER_SIZE_STD, _EXT

        private NativeObject control;
        private CanInitLine2? set;

        internal CanControl2(BalResource at) : base(at)
        {
        }

        public int DetectBaud(CanOperatingModes operatingMode, CanExtendedOperatingModes extendedMode, ushort timeout,
            CanFdBitrate[] bitrateTable)
        {
            Alive();
            int result = Results.InvalidArgument;
            int count = bitrateTable == null ? 0 : bitrateTable.Length;
            uint mode = (uint)(operatingMode & CanOperatingModes.LowSpeed);
            for (int start = 0; start < count; start += Pairs)
            {
                byte[] table = Table(bitrateTable, start, Math.Min(count - start, Pairs));
                fixed (byte* at = table)
                    result = control.Call(ControlSlot.DetectBaud, mode, (uint)extendedMode, timeout, at);
                if (result == Results.Ok)
                    return start + table[1];
                if (result != Results.Timeout)
                    break;
            }
            Check(result);
            return -1;
        }

        public void InitLine(CanOperatingModes operatingMode, CanExtendedOperatingModes extendedMode,
            CanFilterModes filterModeStd, uint cntIdsStd, CanFilterModes filterModeExt, uint cntIdsExt,
            CanBitrate2 bitrate, CanBitrate2 extendedBitrate)
        {
            Alive();
            var init = new CanInitLine2 {
                Mode = (byte)operatingMode, ExtendedMode = (byte)extendedMode,
                StandardFilter = (byte)filterModeStd, ExtendedFilter = (byte)filterModeExt,
                StandardIds = cntIdsStd, ExtendedIds = cntIdsExt,
                Standard = Structure(bitrate), Fast = Structure(extendedBitrate)
            };
            Check(control.Call(ControlSlot.InitLine, &init));
            set = init;
        }

        /// <summary>Offline then, with the settings that it had.</summary>
        public void ResetLine()
        {
            CanLineState2 state = State();
            Check(control.Call(ControlSlot.ResetLine));
            if (state.Mode == 0)
                return;
            CanInitLine2 init = set ?? new CanInitLine2 {
                StandardFilter = (byte)CanFilterModes.Pass, ExtendedFilter = (byte)CanFilterModes.Pass,
                StandardIds = StandardIds, ExtendedIds = ExtendedIds
            };
            init.Mode = (byte)(state.Mode & ~Detecting);
            init.ExtendedMode = state.ExtendedMode;
            init.Standard = state.Standard;
            init.Fast = state.Fast;
            Check(control.Call(ControlSlot.InitLine, &init));
        }

        public void StartLine()
        {
            Alive();
            Check(control.Call(ControlSlot.StartLine));
        }

        public void StopLine()
        {
            Alive();
            Check(control.Call(ControlSlot.StopLine));
        }

        public void SetAccFilter(CanFilter select, uint code, uint mask)
        {
            Alive();
            Check(control.Call(Control2Slot.SetAccFilter, (uint)select, code, mask));
        }

        public void AddFilterIds(CanFilter select, uint code, uint mask)
        {
            Alive();
            Check(control.Call(Control2Slot.AddFilterIds, (uint)select, code, mask));
        }

        public void RemFilterIds(CanFilter select, uint code, uint mask)
        {
            Alive();
            Check(control.Call(Control2Slot.RemFilterIds, (uint)select, code, mask));
        }

        internal override void Open(Place place)
        {
            base.Open(place);
            control = Hold(place.Open(Iid.CanControl2));
        }

        /// <summary>CANBTPTABLE: count, index, and pairs of CANBTP.</summary>
        private static byte[] Table(CanFdBitrate[] rates, int start, int count)
        {
            var made = new byte[2 + Pairs * 2 * sizeof(CanBtp)];
            made[0] = (byte)count;
            fixed (byte* at = made)
                for (int k = 0; k < count; k++)
                {
                    ((CanBtp*)(at + 2))[2 * k] = Structure(rates[start + k].StdBitrate);
                    ((CanBtp*)(at + 2))[2 * k + 1] = Structure(rates[start + k].FastBitrate);
                }
            return made;
        }
    }
}
