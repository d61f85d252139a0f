// What sets a CAN line up. Source: VCI V3 .NET manual 4.2.4; the vendor's published contract of Ixxat.Vci4.
using System;
using Canwire.Native;

#if VCI3
namespace Ixxat.Vci3.Bal.Can
#else
namespace Ixxat.Vci4.Bal.Can
#endif
{
    internal sealed unsafe class CanControl : CanSocket, ICanControl
    {
        private NativeObject control;

        internal CanControl(BalResource at) : base(at)
        {
        }

        public int DetectBaud(ushort timeout, CanBitrate[] bitrateTable)
        {
            Alive();
            int result = Results.InvalidArgument;
            int count = bitrateTable == null ? 0 : bitrateTable.Length;
            for (int start = 0; start < count; start += CanBtrTable.Room)
            {
                var table = new CanBtrTable { Count = (byte)Math.Min(count - start, CanBtrTable.Room) };
                for (int at = 0; at < table.Count; at++)
                {
                    table.Btr0[at] = bitrateTable[start + at].Btr0;
                    table.Btr1[at] = bitrateTable[start + at].Btr1;
                }
                result = control.Call(ControlSlot.DetectBaud, timeout, &table);
                if (result == Results.Ok)
                    return start + table.Index;
                if (result != Results.Timeout)
                    break;
            }
#if VCI3
            if (result == Results.Timeout && timeout > 0)
                return -1;
#endif
            Check(result);
            return -1;
        }

        public void InitLine(CanOperatingModes operatingMode, CanBitrate bitrate)
        {
            Alive();
            var init = new CanInitLine { Mode = (byte)operatingMode, Btr0 = bitrate.Btr0, Btr1 = bitrate.Btr1 };
            Check(control.Call(ControlSlot.InitLine, &init));
        }

        /// <summary>Offline then, with the settings that it had.</summary>
        public void ResetLine()
        {
            CanLineState state;
            Alive();
            Check(control.Call(ControlSlot.GetLineStatus, &state));
            Check(control.Call(ControlSlot.ResetLine));
            const byte detecting = 0x20; // CAN_OPMODE_AUTOBAUD: the rate is known now
            var init = new CanInitLine { Mode = (byte)(state.Mode & ~detecting), Btr0 = state.Btr0, Btr1 = state.Btr1 };
            if (state.Mode != 0 && (state.Btr0 | state.Btr1) != 0)
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
            Check(control.Call(ControlSlot.SetAccFilter, (uint)select, code, mask));
        }

        public void AddFilterIds(CanFilter select, uint code, uint mask)
        {
            Alive();
            Check(control.Call(ControlSlot.AddFilterIds, (uint)select, code, mask));
        }

        public void RemFilterIds(CanFilter select, uint code, uint mask)
        {
            Alive();
            Check(control.Call(ControlSlot.RemFilterIds, (uint)select, code, mask));
        }

        internal override void Open(Place place)
        {
            base.Open(place);
            control = Hold(place.Open(Iid.CanControl));
        }
    }
}
