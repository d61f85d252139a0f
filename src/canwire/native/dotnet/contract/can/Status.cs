// How a line or a channel was when somebody asked. Source: VCI V3 .NET manual 4.2; contract of Ixxat.Vci4.

#if VCI3
namespace Ixxat.Vci3.Bal.Can
#else
namespace Ixxat.Vci4.Bal.Can
#endif
{
    /// <summary>A line; Bitrate is Empty where an SJA1000 cannot make it.</summary>
    public struct CanLineStatus
    {
        private readonly CanOperatingModes opmode;
        private readonly byte busload;
        private readonly CanCtrlStatus ctrlstat;
        private readonly CanBitrate rate;

        public CanLineStatus(CanOperatingModes opmode, byte busload, CanCtrlStatus ctrlstat, CanBitrate rate)
        {
            this.opmode = opmode;
            this.busload = busload;
            this.ctrlstat = ctrlstat;
            this.rate = rate;
        }

        public CanOperatingModes OperatingMode
        {
            get { return opmode; }
        }

        /// <summary>In percent.</summary>
        public byte Busload
        {
            get { return busload; }
        }

        public CanCtrlStatus ControllerStatus
        {
            get { return ctrlstat; }
        }

        public CanBitrate Bitrate
        {
            get { return rate; }
        }

        public bool IsModeUndefined
        {
            get { return (opmode & CanOperatingModes.ModeMask) == 0; }
        }

        public bool IsModeStandard
        {
            get { return (opmode & CanOperatingModes.Standard) != 0; }
        }

        public bool IsModeExtended
        {
            get { return (opmode & CanOperatingModes.Extended) != 0; }
        }

        public bool IsErrorFramesEnabled
        {
            get { return (opmode & CanOperatingModes.ErrFrame) != 0; }
        }

        public bool IsListenOnly
        {
            get { return (opmode & CanOperatingModes.ListenOnly) != 0; }
        }

        public bool IsLowSpeedEnabled
        {
            get { return (opmode & CanOperatingModes.LowSpeed) != 0; }
        }

#if !VCI3
        public bool IsAutomaticBitrateDetectionEnabled
        {
            get { return (opmode & CanOperatingModes.AutoBaudrate) != 0; }
        }
#endif

        public bool IsTransmitPending
        {
            get { return (ctrlstat & CanCtrlStatus.TxPending) != 0; }
        }

        public bool HasDataOverrun
        {
            get { return (ctrlstat & CanCtrlStatus.Overrun) != 0; }
        }

        public bool HasErrorOverrun
        {
            get { return (ctrlstat & CanCtrlStatus.ErrLimit) != 0; }
        }

        public bool IsBusOff
        {
            get { return (ctrlstat & CanCtrlStatus.BusOff) != 0; }
        }

        public bool IsInInitMode
        {
            get { return (ctrlstat & CanCtrlStatus.InInit) != 0; }
        }

        public bool IsBusCErr
        {
            get { return (ctrlstat & CanCtrlStatus.BusCErr) != 0; }
        }

        public override string ToString()
        {
            return string.Format("opmode: {0}, busload: {1}, ctrlstat: {2}, bitrate: {3}", opmode, busload, ctrlstat, rate);
        }
    }

    /// <summary>A channel.</summary>
    public struct CanChannelStatus
    {
        private readonly bool activated;
        private readonly bool rxOverrun;
        private readonly byte rxFifoLoad;
        private readonly byte txFifoLoad;

        public CanChannelStatus(bool activated, bool rxOverrun, byte rxFifoLoad, byte txFifoLoad)
        {
            this.activated = activated;
            this.rxOverrun = rxOverrun;
            this.rxFifoLoad = rxFifoLoad;
            this.txFifoLoad = txFifoLoad;
        }

        public bool IsActivated
        {
            get { return activated; }
        }

        /// <summary>Messages were lost since Initialize.</summary>
        public bool HasFifoOverrun
        {
            get { return rxOverrun; }
        }

        /// <summary>In percent.</summary>
        public byte ReceiveFifoLoad
        {
            get { return rxFifoLoad; }
        }

        /// <summary>In percent.</summary>
        public byte TransmitFifoLoad
        {
            get { return txFifoLoad; }
        }
    }
}
