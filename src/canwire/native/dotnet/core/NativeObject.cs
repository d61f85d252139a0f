// Objects of libvciapi, whose methods are called by their place in the vtable.
using System;
using System.Collections.Concurrent;
using System.Runtime.InteropServices;

namespace Canwire.Native
{
    /// <summary>
    /// One reference to an object of libvciapi. Methods are numbered as vcisdk.h has them, QueryInterface being 0. A method
    /// returns VCI's result code, which is why nothing here throws.
    /// </summary>
    internal sealed unsafe class NativeObject
    {
        private const int ReleaseSlot = 2;

        [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
        private delegate int Plain(IntPtr self);

        [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
        private delegate int OfOne(IntPtr self, IntPtr one);

        [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
        private delegate int OfTwo(IntPtr self, IntPtr one, IntPtr two);

        [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
        private delegate int OfThree(IntPtr self, IntPtr one, IntPtr two, IntPtr three);

        [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
        private delegate int OfFour(IntPtr self, IntPtr one, IntPtr two, IntPtr three, IntPtr four);

        private readonly IntPtr self;

        internal NativeObject(IntPtr self)
        {
            this.self = self;
        }

        internal int Call(int slot)
        {
            return Method<Plain>(slot)(self);
        }

        internal int Call(int slot, void* one)
        {
            return Method<OfOne>(slot)(self, (IntPtr)one);
        }

        internal int Call(int slot, uint one)
        {
            return Method<OfOne>(slot)(self, Word(one));
        }

        internal int Call(int slot, uint one, void* two)
        {
            return Method<OfTwo>(slot)(self, Word(one), (IntPtr)two);
        }

        internal int Call(int slot, void* one, void* two)
        {
            return Method<OfTwo>(slot)(self, (IntPtr)one, (IntPtr)two);
        }

        internal int Call(int slot, uint one, uint two)
        {
            return Method<OfTwo>(slot)(self, Word(one), Word(two));
        }

        internal int Call(int slot, uint one, void* two, void* three)
        {
            return Method<OfThree>(slot)(self, Word(one), (IntPtr)two, (IntPtr)three);
        }

        internal int Call(int slot, void* one, void* two, void* three)
        {
            return Method<OfThree>(slot)(self, (IntPtr)one, (IntPtr)two, (IntPtr)three);
        }

        internal int Call(int slot, uint one, uint two, void* three)
        {
            return Method<OfThree>(slot)(self, Word(one), Word(two), (IntPtr)three);
        }

        internal int Call(int slot, uint one, uint two, uint three)
        {
            return Method<OfThree>(slot)(self, Word(one), Word(two), Word(three));
        }

        internal int Call(int slot, uint one, uint two, uint three, uint four)
        {
            return Method<OfFour>(slot)(self, Word(one), Word(two), Word(three), Word(four));
        }

        internal int Call(int slot, uint one, uint two, uint three, void* four)
        {
            return Method<OfFour>(slot)(self, Word(one), Word(two), Word(three), (IntPtr)four);
        }

        internal void Release()
        {
            Call(ReleaseSlot);
        }

        private T Method<T>(int slot) where T : class
        {
            return Methods<T>.At(((IntPtr**)self)[0][slot]);
        }

        private static IntPtr Word(uint value) // the callee looks at the bits that its parameter has
        {
            return (IntPtr)unchecked((int)value);
        }

        private static class Methods<T> where T : class
        {
            private static readonly ConcurrentDictionary<IntPtr, T> made = new ConcurrentDictionary<IntPtr, T>();

            internal static T At(IntPtr address)
            {
                T found;
                if (!made.TryGetValue(address, out found))
                    found = made.GetOrAdd(address, (T)(object)Marshal.GetDelegateForFunctionPointer(address, typeof(T)));
                return found;
            }
        }
    }
}
