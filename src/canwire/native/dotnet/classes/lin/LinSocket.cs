// What a LIN line can do and how it is. Source: VCI V3 .NET manual 4.3.2; the contract of Ixxat.Vci4.
using Canwire.Native;

#if VCI3
namespace Ixxat.Vci3.Bal.Lin
#else
namespace Ixxat.Vci4.Bal.Lin
#endif
{
    internal unsafe class LinSocket : BalResource, ILinSocket
    {
        private LinCapabilities capabilities;

        internal LinSocket(BalResource at) : base(at)
        {
        }

        public LinLineStatus LineStatus
        {
            get
            {
                LinLineState state = State();
                return new LinLineStatus((LinOperatingModes)state.Mode, state.Load, (LinCtrlStatus)state.Status, state.Bitrate);
            }
        }

        public LinFeatures Features
        {
            get { return (LinFeatures)Caps().Features; }
        }

        public bool SupportsMasterMode
        {
            get { return Has(LinFeatures.Master); }
        }

        public bool SupportsAutorate
        {
            get { return Has(LinFeatures.Autorate); }
        }

        public bool SupportsErrorFrames
        {
            get { return Has(LinFeatures.ErrFrame); }
        }

        public bool SupportsBusLoadComputation
        {
            get { return Has(LinFeatures.Busload); }
        }

        public uint ClockFrequency
        {
            get { return Caps().Clock; }
        }

        public uint TimeStampCounterDivisor
        {
            get { return Caps().TimeStampDivisor; }
        }

        internal NativeObject Socket { get; private set; }

        internal override void Open(Place place)
        {
            LinCapabilities read;
            Socket = Hold(place.Open(Iid.LinSocket));
            Check(Socket.Call(SocketSlot.GetCapabilities, &read));
            capabilities = read;
        }

        internal LinLineState State()
        {
            LinLineState state;
            Alive();
            Check(Socket.Call(SocketSlot.GetLineStatus, &state));
            return state;
        }

        private bool Has(LinFeatures feature)
        {
            return (Features & feature) != 0;
        }

        private LinCapabilities Caps()
        {
            Alive();
            return capabilities;
        }
    }
}
