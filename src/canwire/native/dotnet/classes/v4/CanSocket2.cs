// What a CAN FD line can do and how it is. Source: the vendor's published contract of Ixxat.Vci4.
using System;
using Canwire.Native;

namespace Ixxat.Vci4.Bal.Can
{
    internal unsafe class CanSocket2 : CanConnector, ICanSocket2
    {
        internal CanSocket2(BalResource at) : base(at)
        {
        }

        internal override Guid SocketIid
        {
            get { return Iid.CanSocket2; }
        }

        public uint CanClockFrequency
        {
            get { return Caps().CanClock; }
        }

        public uint TimeStampCounterClockFrequency
        {
            get { return Caps().TimeStampClock; }
        }

        public uint CyclicMessageTimerClockFrequency
        {
            get { return Caps().CyclicClock; }
        }

        public uint DelayedTXTimerClockFrequency
        {
            get { return Caps().DelayClock; }
        }

        public CanBitrate2 MinimumArbitrationBitrate
        {
            get { return Rate(Caps().SlowestArbitration); }
        }

        public CanBitrate2 MaximumArbitrationBitrate
        {
            get { return Rate(Caps().FastestArbitration); }
        }

        public CanBitrate2 MinimumFastDataBitrate
        {
            get { return Rate(Caps().SlowestData); }
        }

        public CanBitrate2 MaximumFastDataBitrate
        {
            get { return Rate(Caps().FastestData); }
        }

        public bool SupportsSingleShotMessages
        {
            get { return Has(CanFeatures.SingleShot); }
        }

        public bool SupportsHighPriorityMessages
        {
            get { return Has(CanFeatures.HighPriorityMsg); }
        }

        public bool SupportsAutoBaudrateDetection
        {
            get { return Has(CanFeatures.AutoBaudrate); }
        }

        public bool SupportsExtendedDataLength
        {
            get { return Has(CanFeatures.ExtendedDataLength); }
        }

        public bool SupportsFastDataRate
        {
            get { return Has(CanFeatures.FastDataRate); }
        }

        public bool SupportsIsoCanFdFrames
        {
            get { return Has(CanFeatures.IsoCanFd); }
        }

        public bool SupportsNonIsoCanFdFrames
        {
            get { return Has(CanFeatures.NonIsoCanFd); }
        }

        public bool Supports64BitTimeStamps
        {
            get { return Has(CanFeatures.LongBitTimeStamp); }
        }

        public CanLineStatus2 LineStatus
        {
            get
            {
                CanLineState2 state = State();
                return new CanLineStatus2((CanOperatingModes)state.Mode, (CanExtendedOperatingModes)state.ExtendedMode,
                    state.Load, (CanCtrlStatus)state.Status, Rate(state.Standard), Rate(state.Fast));
            }
        }

        internal CanLineState2 State()
        {
            CanLineState2 state;
            Alive();
            Check(Socket.Call(SocketSlot.GetLineStatus, &state));
            return state;
        }

        internal static CanBitrate2 Rate(CanBtp from)
        {
            return new CanBitrate2((CanBitrateMode)from.Mode, from.Prescaler, from.TimeSegment1, from.TimeSegment2,
                from.Sjw, from.Delay);
        }

        internal static CanBtp Structure(CanBitrate2 from)
        {
            return new CanBtp {
                Mode = (uint)from.Mode, Prescaler = from.Prescaler, TimeSegment1 = from.TimeSegment1,
                TimeSegment2 = from.TimeSegment2, Sjw = from.Sjw, Delay = from.TransmitterDelay
            };
        }
    }
}
