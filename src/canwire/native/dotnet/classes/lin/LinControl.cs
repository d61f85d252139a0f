// What sets a LIN line up and sends on it. Source: VCI V3 .NET manual 4.3.4; the contract of Ixxat.Vci4.
using System;
using Canwire.Native;

#if VCI3
namespace Ixxat.Vci3.Bal.Lin
#else
namespace Ixxat.Vci4.Bal.Lin
#endif
{
    internal sealed unsafe class LinControl : LinSocket, ILinControl
    {
        private const ushort Undefined = 0xFFFF; // LIN_BITRATE_UNDEF

        private NativeObject control;

        internal LinControl(BalResource at) : base(at)
        {
        }

        public void InitLine(LinInitLine initLine)
        {
            Alive();
            Init(new LinInit { Mode = (byte)initLine.OperatingMode, Bitrate = initLine.Bitrate.AsUInt16 });
        }

        /// <summary>Offline then, with the settings that it had and an empty response table.</summary>
        public void ResetLine()
        {
            LinLineState state = State();
            Check(control.Call(LinControlSlot.ResetLine));
            if (state.Bitrate != Undefined)
                Init(new LinInit { Mode = state.Mode, Bitrate = state.Bitrate });
        }

        public void StartLine()
        {
            Alive();
            Check(control.Call(LinControlSlot.StartLine));
        }

        public void StopLine()
        {
            Alive();
            Check(control.Call(LinControlSlot.StopLine));
        }

#if VCI3
        public void WriteMessage(bool send, LinMessage message)
        {
            Write(send, message.Raw);
        }
#else
        public void WriteMessage(bool send, ILinMessage message)
        {
            var known = message as LinMessage;
            Alive();
            if (known == null)
                throw new ArgumentException("a message of MsgFactory.CreateMsg belongs here, not " + (message ?? (object)"null"), "message");
            Write(send, known.Raw);
        }
#endif

        internal override void Open(Place place)
        {
            base.Open(place);
            control = Hold(place.Open(Iid.LinControl));
        }

        private void Write(bool send, LinMsg raw)
        {
            Alive();
            Check(control.Call(LinControlSlot.WriteMessage, send ? 1u : 0u, &raw));
        }

        private void Init(LinInit init)
        {
            Check(control.Call(LinControlSlot.InitLine, &init));
        }
    }
}
