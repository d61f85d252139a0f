// What a CAN line can do and how it is. Source: VCI V3 .NET manual 4.2.2; the contract of Ixxat.Vci4.
using System;
using Canwire.Native;

#if VCI3
namespace Ixxat.Vci3.Bal.Can
#else
namespace Ixxat.Vci4.Bal.Can
#endif
{
    /// <summary>What both kinds of sockets have: the capabilities of ICanSocket2, read when it is opened.</summary>
    internal abstract unsafe class CanConnector : BalResource
    {
        private CanCapabilities2 capabilities;

        internal CanConnector(BalResource at) : base(at)
        {
        }

        public CanCtrlType ControllerType
        {
            get
            {
                var kind = (CanCtrlType)Caps().Controller;
                return Enum.IsDefined(typeof(CanCtrlType), kind) ? kind : CanCtrlType.Unknown;
            }
        }

        public CanBusCouplings BusCoupling
        {
            get { return (CanBusCouplings)Caps().Coupling; }
        }

        public CanFeatures Features
        {
            get
            {
                uint word = Caps().Features;
#if VCI3
                const uint same = (uint)CanFeatures.CanFd - 1, fd = 0x6000; // CAN_FEATURE_EXTDATA, _FASTDATA
                return (CanFeatures)(word & same) | ((word & fd) != 0 ? CanFeatures.CanFd : 0);
#else
                return (CanFeatures)word;
#endif
            }
        }

        public uint TimeStampCounterDivisor
        {
            get { return Caps().TimeStampDivisor; }
        }

        public uint CyclicMessageTimerDivisor
        {
            get { return Caps().CyclicDivisor; }
        }

        public uint MaxCyclicMessageTicks
        {
            get { return Caps().CyclicTicks; }
        }

        public uint DelayedTXTimerDivisor
        {
            get { return Caps().DelayDivisor; }
        }

        public uint MaxDelayedTXTicks
        {
            get { return Caps().DelayTicks; }
        }

        public bool SupportsStdOrExtFrames
        {
            get { return Has(CanFeatures.StdOrExt); }
        }

        public bool SupportsStdAndExtFrames
        {
            get { return Has(CanFeatures.StdAndExt); }
        }

        public bool SupportsRemoteFrames
        {
            get { return Has(CanFeatures.RemoteFrame); }
        }

        public bool SupportsErrorFrames
        {
            get { return Has(CanFeatures.ErrFrame); }
        }

        public bool SupportsBusLoadComputation
        {
            get { return Has(CanFeatures.Busload); }
        }

        public bool SupportsExactMessageFilter
        {
            get { return Has(CanFeatures.IdFilter); }
        }

        public bool SupportsListenOnlyMode
        {
            get { return Has(CanFeatures.ListOnly); }
        }

        public bool SupportsCyclicMessageScheduler
        {
            get { return Has(CanFeatures.Scheduler); }
        }

        public bool SupportsErrorFrameGeneration
        {
            get { return Has(CanFeatures.GenErrFrame); }
        }

        public bool SupportsDelayedTransmission
        {
            get { return Has(CanFeatures.DelayedTX); }
        }

        internal NativeObject Socket { get; private set; }

        internal abstract Guid SocketIid { get; }

        internal override void Open(Place place)
        {
            CanCapabilities2 read;
            Socket = Hold(place.Open(SocketIid));
            NativeObject two = Hold(place.Open(Iid.CanSocket2));
            Check(two.Call(SocketSlot.GetCapabilities, &read));
            Drop(two);
            capabilities = read;
        }

        internal bool Has(CanFeatures feature)
        {
            return (Features & feature) != 0;
        }

        internal CanCapabilities2 Caps()
        {
            Alive();
            return capabilities;
        }
    }

    internal unsafe class CanSocket : CanConnector, ICanSocket
    {
        private uint clock;

        internal CanSocket(BalResource at) : base(at)
        {
        }

        internal override Guid SocketIid
        {
            get { return Iid.CanSocket; }
        }

        public uint ClockFrequency
        {
            get
            {
                Alive();
                return clock;
            }
        }

        public CanLineStatus LineStatus
        {
            get
            {
                CanLineState state;
                Alive();
                Check(Socket.Call(SocketSlot.GetLineStatus, &state));
                return new CanLineStatus((CanOperatingModes)state.Mode, state.Load, (CanCtrlStatus)state.Status,
                    Named(new CanBitrate(state.Btr0, state.Btr1)));
            }
        }

#if VCI3
        public uint CyclicMessageTimeDivisor
        {
            get { return CyclicMessageTimerDivisor; }
        }

        public uint MaxCyclicMsgTicks
        {
            get { return MaxCyclicMessageTicks; }
        }
#endif

        internal override void Open(Place place)
        {
            CanCapabilities read;
            base.Open(place);
            Check(Socket.Call(SocketSlot.GetCapabilities, &read));
            clock = read.Clock;
        }

        private static CanBitrate Named(CanBitrate rate)
        {
            foreach (CanBitrate known in CanBitrate.CiaBitRates)
                if (known == rate)
                    return known;
            return rate == CanBitrate._100KBit ? CanBitrate._100KBit : rate;
        }
    }
}
