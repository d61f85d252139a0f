// The queue of a channel or a monitor, made anew where Initialize asks for another exclusiveness.
using System;
using Canwire.Native;

#if VCI3
namespace Ixxat.Vci3.Bal
#else
namespace Ixxat.Vci4.Bal
#endif
{
    /// <summary>
    /// What channels and monitors do with VCI's. There is a queue from Initialize on; before that their calls throw
    /// ObjectDisposedException, as the vendor's do.
    /// </summary>
    internal sealed unsafe class QueueOwner
    {
        private readonly BalResource owner;
        private readonly NativeObject socket;
        private NativeObject queue;
        private bool exclusive;

        internal QueueOwner(BalResource owner, NativeObject socket)
        {
            this.owner = owner;
            this.socket = socket;
        }

        /// <summary>The queue to be initialised; the one before goes where it was not as exclusive.</summary>
        internal NativeObject Prepared(bool alone)
        {
            lock (owner.Gate)
            {
                owner.Alive();
                if (queue != null && alone == exclusive)
                    return queue;
                IntPtr made;
                owner.Drop(queue);
                queue = null;
                Disposable.Check(socket.Call(SocketSlot.CreateQueue, alone ? 1u : 0u, &made));
                queue = owner.Hold(made);
                exclusive = alone;
                return queue;
            }
        }

        internal NativeObject Queue
        {
            get
            {
                owner.Alive();
                NativeObject found = queue;
                if (found == null)
                    throw new ObjectDisposedException(owner.GetType().FullName, owner.BusName + ": call Initialize first");
                return found;
            }
        }

        internal void Activate()
        {
            Disposable.Check(Queue.Call(QueueSlot.Activate));
        }

        internal void Deactivate()
        {
            Disposable.Check(Queue.Call(QueueSlot.Deactivate));
        }

        /// <summary>A new reader or writer.</summary>
        internal IntPtr End(int slot)
        {
            IntPtr made;
            Disposable.Check(Queue.Call(slot, &made));
            return made;
        }
    }
}
