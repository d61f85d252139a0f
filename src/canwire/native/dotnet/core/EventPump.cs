// An event of libcanwire's, and a thread that sets a .NET event whenever the first one is signalled.
using System;
using System.Threading;

namespace Canwire.Native
{
    /// <summary>
    /// .NET's events are not libcanwire's: what is assigned to a FIFO is a native event, and this thread, which costs
    /// nothing while nothing happens, hands each signal on. It ends with Dispose, or with the program.
    /// </summary>
    internal sealed class EventPump : IDisposable
    {
        private const uint Forever = 0xFFFFFFFF;

        private readonly EventWaitHandle target;
        private readonly Thread thread;
        private volatile bool ended;

        internal EventPump(EventWaitHandle target)
        {
            this.target = target;
            Handle = Library.CreateEventA(IntPtr.Zero, 0, 0, IntPtr.Zero);
            if (Handle == IntPtr.Zero)
                throw new OutOfMemoryException("VCI has no room for another event");
            thread = new Thread(Run) { IsBackground = true, Name = "canwire events" };
            thread.Start();
        }

        /// <summary>The native event.</summary>
        internal IntPtr Handle { get; private set; }

        /// <summary>End the thread; nothing may signal the native event from now on.</summary>
        public void Dispose()
        {
            if (ended)
                return;
            ended = true;
            Library.SetEvent(Handle);
            thread.Join();
            Library.CloseHandle(Handle);
        }

        private void Run()
        {
            while (Library.WaitForSingleObject(Handle, Forever) == 0 && !ended)
                try
                {
                    target.Set();
                }
                catch (ObjectDisposedException) // the program has thrown its event away: nobody waits for it
                {
                    return;
                }
        }
    }
}
