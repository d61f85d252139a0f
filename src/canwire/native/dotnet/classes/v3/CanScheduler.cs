// The cyclic list of a line. Source: VCI V3 .NET manual 4.2.5.
using System;
using System.Collections.Generic;
using Canwire.Native;

namespace Ixxat.Vci3.Bal.Can
{
    /// <summary>A cyclic message; a list takes a copy of it, and what is changed later counts from the next AddMessage on.</summary>
    public sealed class CanCyclicTXMsg : CyclicMessageBase
    {
        /// <summary>As ICanScheduler.UpdateStatus found it last; Empty before the first start and off the list.</summary>
        public CanCyclicTXStatus Status { get; internal set; }

        internal override bool IsLong
        {
            get { return false; }
        }
    }

    internal sealed unsafe class CanScheduler : CanSocket, ICanScheduler
    {
        private readonly Dictionary<CanCyclicTXMsg, uint> listed = new Dictionary<CanCyclicTXMsg, uint>();
        private NativeObject list;

        internal CanScheduler(BalResource at) : base(at)
        {
        }

        public void Suspend()
        {
            Alive();
            Check(list.Call(SchedulerSlot.Suspend));
        }

        public void Resume()
        {
            Alive();
            Check(list.Call(SchedulerSlot.Resume));
        }

        public void Reset()
        {
            lock (listed)
            {
                Alive();
                Check(list.Call(SchedulerSlot.Reset));
                foreach (CanCyclicTXMsg message in listed.Keys)
                    message.Status = CanCyclicTXStatus.Empty;
                listed.Clear();
            }
        }

        public void UpdateStatus()
        {
            lock (listed)
            {
                CanSchedulerState state;
                if (IsDisposed)
                    return;
                Check(list.Call(SchedulerSlot.GetStatus, &state));
                foreach (var one in listed)
                    one.Key.Status = (CanCyclicTXStatus)state.Messages[one.Value];
            }
        }

        public void AddMessage(CanCyclicTXMsg message)
        {
            lock (listed)
            {
                uint index;
                Alive();
                if (message == null)
                    throw new ArgumentNullException("message");
                if (listed.ContainsKey(message))
                    throw new ArgumentException("the message is on the list", "message");
                CanCyclicMsg structure = message.Structure();
                Check(list.Call(SchedulerSlot.AddMessage, &structure, &index));
                listed[message] = index;
            }
        }

        public void RemoveMessage(CanCyclicTXMsg message)
        {
            lock (listed)
            {
                Check(list.Call(SchedulerSlot.RemMessage, Index(message)));
                listed.Remove(message);
                message.Status = CanCyclicTXStatus.Empty;
            }
        }

        public void StartMessage(CanCyclicTXMsg message, ushort repeatCount)
        {
            lock (listed)
            {
                Check(list.Call(SchedulerSlot.StartMessage, Index(message), (uint)repeatCount));
            }
        }

        public void StopMessage(CanCyclicTXMsg message)
        {
            lock (listed)
            {
                Check(list.Call(SchedulerSlot.StopMessage, Index(message)));
            }
        }

        internal override void Open(Place place)
        {
            base.Open(place);
            list = Hold(place.Open(Iid.CanScheduler));
        }

        private uint Index(CanCyclicTXMsg message)
        {
            uint found;
            Alive();
            if (message == null || !listed.TryGetValue(message, out found))
                throw new ArgumentException("the message is not on this list", "message");
            return found;
        }
    }
}
