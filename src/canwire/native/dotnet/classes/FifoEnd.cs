// One end of a FIFO. Source: VCI V3 .NET manual 3.1; the vendor's published contract of Ixxat.Vci4.
using System;
using System.Threading;
using Canwire.Native;

#if VCI3
namespace Ixxat.Vci3.Bal
#else
namespace Ixxat.Vci4.Bal
#endif
{
    /// <summary>What readers and writers have in common. Disposed, its counts and its threshold are 0.</summary>
    internal abstract unsafe class FifoEnd : Disposable
    {
        private readonly Assignment assignment;

        internal FifoEnd(IntPtr end)
        {
            End = Hold(end);
            assignment = new Assignment(End, FifoSlot.AssignEvent);
        }

        internal NativeObject End { get; private set; }

        public ushort Capacity
        {
            get { return Count(FifoSlot.GetCapacity); }
        }

        public ushort Threshold
        {
            get { return Count(FifoSlot.GetThreshold); }
            set
            {
                Alive();
                Check(End.Call(FifoSlot.SetThreshold, value));
            }
        }

        public void Lock()
        {
            Alive();
            Check(End.Call(FifoSlot.Lock));
        }

        public void Unlock()
        {
            Alive();
            Check(End.Call(FifoSlot.Unlock));
        }

        public void AssignEvent(AutoResetEvent fifoEvent)
        {
            Assign(fifoEvent);
        }

        public void AssignEvent(ManualResetEvent fifoEvent)
        {
            Assign(fifoEvent);
        }

        internal ushort Count(int slot)
        {
            ushort count;
            if (IsDisposed)
                return 0;
            Check(End.Call(slot, &count));
            return count;
        }

        /// <summary>Read one element; false if there is none.</summary>
        internal bool Take(void* into)
        {
            return Done(End.Call(FifoSlot.Entry, into), Results.ReceiveQueueEmpty);
        }

        /// <summary>Write one element; false if there is no room.</summary>
        internal bool Put(void* element)
        {
            return Done(End.Call(FifoSlot.Entry, element), Results.TransmitQueueFull);
        }

        /// <summary>The elements that lie together in the FIFO's memory; null if there are none.</summary>
        internal void* Acquire(out ushort count)
        {
            void* elements;
            ushort there;
            bool any = Done(End.Call(FifoSlot.Acquire, &elements, &there), Results.ReceiveQueueEmpty);
            count = any ? there : (ushort)0;
            return any ? elements : null;
        }

        internal void Release(ushort count)
        {
            Check(End.Call(FifoSlot.Release, count));
        }

        internal override void Ending()
        {
            assignment.Dispose();
        }

        private bool Done(int result, int not)
        {
            if (result == not)
                return false;
            Check(result);
            return true;
        }

        private void Assign(EventWaitHandle target)
        {
            Alive();
            Check(assignment.Assign(target));
        }
    }
}
