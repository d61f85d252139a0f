// How a CAN FD line was when somebody asked. Source: the vendor's published contract of Ixxat.Vci4.
namespace Ixxat.Vci4.Bal.Can
{
    /// <summary>A CAN FD line, with both its bit rates.</summary>
    public struct CanLineStatus2
    {
        private readonly CanOperatingModes opmode;
        private readonly CanExtendedOperatingModes exmode;
        private readonly byte busload;
        private readonly CanCtrlStatus ctrlstat;
        private readonly CanBitrate2 rate;
        private readonly CanBitrate2 fastrate;

        public CanLineStatus2(CanOperatingModes opmode, CanExtendedOperatingModes exmode, byte busload, CanCtrlStatus ctrlstat, CanBitrate2 rate, CanBitrate2 fastrate)
        {
            this.opmode = opmode;
            this.exmode = exmode;
            this.busload = busload;
            this.ctrlstat = ctrlstat;
            this.rate = rate;
            this.fastrate = fastrate;
        }

        public CanOperatingModes OperatingMode
        {
            get { return opmode; }
        }

        public CanExtendedOperatingModes ExtendedOperatingMode
        {
            get { return exmode; }
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

        public CanBitrate2 Bitrate
        {
            get { return rate; }
        }

        public CanBitrate2 FastBitrate
        {
            get { return fastrate; }
        }

        public bool IsStdModeEnabled
        {
            get { return (opmode & CanOperatingModes.Standard) != 0; }
        }

        public bool IsExtModeEnabled
        {
            get { return (opmode & CanOperatingModes.Extended) != 0; }
        }

        public bool IsErrModeEnabled
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

        public bool IsAutomaticBitrateDetectionEnabled
        {
            get { return (opmode & CanOperatingModes.AutoBaudrate) != 0; }
        }

        public bool IsExtendedDataLengthEnabled
        {
            get { return (exmode & CanExtendedOperatingModes.ExtendedDataLength) != 0; }
        }

        public bool IsFastDataEnabled
        {
            get { return (exmode & CanExtendedOperatingModes.FastDataRate) != 0; }
        }

        public bool IsNonIsoCanFdEnabled
        {
            get { return (exmode & CanExtendedOperatingModes.NonIsoCanFd) != 0; }
        }

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
            return string.Format(
                "opmode: {0}, exmode: {1}, busload: {2}, ctrlstat: {3}, stdbitrate: {4}, fastbitrate: {5}",
                opmode, exmode, busload, ctrlstat, rate, fastrate);
        }
    }
}
