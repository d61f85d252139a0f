// The cyclic list of a line, with the messages that it makes. Source: the vendor's published contract of Ixxat.Vci4.
using System;
using System.Collections.Generic;
using System.Linq;
using Canwire.Native;

namespace Ixxat.Vci4.Bal.Can
{
    /// <summary>What both kinds of lists do. It runs from the beginning, other than V3's, which waits for Resume.</summary>
    internal sealed unsafe class CyclicList
    {
        private const int Room = 16; // CAN_MAX_CTX_MSGS

        private readonly BalResource owner;
        private readonly NativeObject list;
        private readonly bool isLong;
        private readonly List<CanCyclicTXMsg> messages = new List<CanCyclicTXMsg>();
        private readonly Dictionary<CanCyclicTXMsg, KeyValuePair<uint, byte[]>> sent =
            new Dictionary<CanCyclicTXMsg, KeyValuePair<uint, byte[]>>(); // index in VCI's list, and what was put there

        internal CyclicList(BalResource owner, NativeObject list, bool isLong)
        {
            this.owner = owner;
            this.list = list;
            this.isLong = isLong;
            Disposable.Check(list.Call(SchedulerSlot.Resume));
        }

        internal CanCyclicTXMsg Add()
        {
            lock (messages)
            {
                owner.Alive();
                if (messages.Count == Room)
                    throw new ArgumentOutOfRangeException("message", "the list of " + owner.BusName + " has its 16 messages");
                var made = new CanCyclicTXMsg(this, isLong);
                messages.Add(made);
                return made;
            }
        }

        internal void Call(int slot)
        {
            owner.Alive();
            Disposable.Check(list.Call(slot));
        }

        internal void Reset()
        {
            lock (messages)
            {
                Call(SchedulerSlot.Reset);
                messages.Clear();
                sent.Clear();
            }
        }

        /// <summary>Put it on VCI's list as it is now, and start it.</summary>
        internal void Start(CanCyclicTXMsg message, ushort count)
        {
            lock (messages)
            {
                owner.Alive();
                if (!messages.Contains(message))
                    throw new InvalidOperationException(
                        "the list of " + owner.BusName + " was reset: AddMessage makes another message");
                CanCyclicMsg structure = message.Adapted();
                byte[] content = Bytes(&structure);
                KeyValuePair<uint, byte[]> before;
                if (!sent.TryGetValue(message, out before) || !before.Value.SequenceEqual(content))
                {
                    uint index;
                    Remove(message);
                    Disposable.Check(list.Call(SchedulerSlot.AddMessage, &structure, &index));
                    sent[message] = before = new KeyValuePair<uint, byte[]>(index, content);
                }
                Disposable.Check(list.Call(SchedulerSlot.StartMessage, before.Key, (uint)count));
            }
        }

        internal void Stop(CanCyclicTXMsg message)
        {
            lock (messages)
            {
                KeyValuePair<uint, byte[]> found;
                owner.Alive();
                if (sent.TryGetValue(message, out found))
                    Disposable.Check(list.Call(SchedulerSlot.StopMessage, found.Key));
            }
        }

        internal void Remove(CanCyclicTXMsg message)
        {
            lock (messages)
            {
                KeyValuePair<uint, byte[]> found;
                owner.Alive();
                if (!sent.TryGetValue(message, out found))
                    return;
                sent.Remove(message);
                Disposable.Check(list.Call(SchedulerSlot.RemMessage, found.Key));
            }
        }

        internal CanCyclicTXStatus State(CanCyclicTXMsg message)
        {
            lock (messages)
            {
                KeyValuePair<uint, byte[]> found;
                if (owner.IsDisposed || !sent.TryGetValue(message, out found))
                    return CanCyclicTXStatus.Empty;
                CanSchedulerState2 both;
                CanSchedulerState* state = &both.List; // ICanScheduler2's has the line's state in front
                Disposable.Check(list.Call(SchedulerSlot.GetStatus, isLong ? (void*)&both : state));
                return (CanCyclicTXStatus)state->Messages[found.Key];
            }
        }

        private byte[] Bytes(CanCyclicMsg* from)
        {
            var made = new byte[sizeof(CanCyclicMsg)];
            for (int at = 0; at < made.Length; at++)
                made[at] = ((byte*)from)[at];
            return made;
        }
    }

    /// <summary>A message of a cyclic list, of up to 8 or 64 bytes as the list has them.</summary>
    internal sealed class CanCyclicTXMsg : CyclicMessageBase, ICanCyclicTXMsg, ICanCyclicTXMsg2
    {
        private readonly CyclicList list;
        private readonly bool isLong;

        internal CanCyclicTXMsg(CyclicList list, bool isLong)
        {
            this.list = list;
            this.isLong = isLong;
        }

        public CanCyclicTXStatus Status
        {
            get { return list.State(this); }
        }

        public void Start(ushort repeatCount)
        {
            list.Start(this, repeatCount);
        }

        public void Stop()
        {
            list.Stop(this);
        }

        /// <summary>Give its place in the cycles to others; it may be started again.</summary>
        public void Reset()
        {
            list.Remove(this);
        }

        internal override bool IsLong
        {
            get { return isLong; }
        }

        /// <summary>Without counting in bytes that are not sent: VCI refuses those, .NET's programs have them.</summary>
        internal CanCyclicMsg Adapted()
        {
            CanCyclicMsg made = Structure();
            int counted = AutoIncrementMode == CanCyclicTXIncMode.Inc16 ? 2 : AutoIncrementMode == CanCyclicTXIncMode.Inc8 ? 1 : 0;
            int there = DataLength - AutoIncrementIndex;
            if (there >= counted)
                return made;
            made.Mode = (byte)(there == 1 ? CanCyclicTXIncMode.Inc8 : CanCyclicTXIncMode.NoInc);
            made.Index = (byte)(there == 1 ? AutoIncrementIndex : 0);
            return made;
        }
    }
}
