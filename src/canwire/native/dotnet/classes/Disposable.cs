// Objects that hold native ones until Dispose, and VCI's results as exceptions.
using System;
using System.Collections.Generic;
using Canwire.Native;

#if VCI3
namespace Ixxat.Vci3
#else
namespace Ixxat.Vci4
#endif
{
    /// <summary>Holds references until Dispose, which may be called again; other calls throw ObjectDisposedException then.</summary>
    internal abstract unsafe class Disposable : IDisposable
    {
        /// <summary>Whoever uses memory of a native object's has this; so has Dispose.</summary>
        internal readonly object Gate = new object();

        private readonly List<NativeObject> held = new List<NativeObject>();
        private volatile bool disposed;

        internal Disposable()
        {
        }

        public void Dispose()
        {
            lock (Gate)
            {
                if (disposed)
                    return;
                disposed = true;
                Ending();
                for (int at = held.Count - 1; at >= 0; at--)
                    held[at].Release();
                held.Clear();
            }
        }

        /// <summary>What a kind has to do before its references go.</summary>
        internal virtual void Ending()
        {
        }

        internal bool IsDisposed
        {
            get { return disposed; }
        }

        internal void Alive()
        {
            if (disposed)
                throw new ObjectDisposedException(GetType().FullName);
        }

        internal NativeObject Hold(IntPtr reference)
        {
            var made = new NativeObject(reference);
            lock (Gate)
                if (!disposed)
                {
                    held.Add(made);
                    return made;
                }
            made.Release(); // another thread was quicker
            throw new ObjectDisposedException(GetType().FullName);
        }

        internal void Drop(NativeObject one)
        {
            lock (Gate)
                if (one != null && held.Remove(one))
                    one.Release();
        }

        internal static void Check(int result)
        {
            if (result != Results.Ok)
#if VCI3
                throw new VciException(result);
#else
                throw new VciException(VciServer.Instance(), result);
#endif
        }
    }
}
