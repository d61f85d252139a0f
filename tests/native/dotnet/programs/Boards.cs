// What every test program uses: boards of the hub, checks, and waiting for messages.
using System;
using System.Collections.Generic;
using System.Threading;
#if VCI3
using Ixxat.Vci3;
using Ixxat.Vci3.Bal;
#else
using Ixxat.Vci4;
using Ixxat.Vci4.Bal;
#endif

static class Boards
{
    public const int Long = 30000; // ms, after which something that should happen never will

    public static IBalObject Open(int number)
    {
#if VCI3
        using (IVciDeviceManager manager = VciServer.GetDeviceManager())
#else
        using (IVciDeviceManager manager = VciServer.Instance().DeviceManager)
#endif
        using (IVciDeviceList list = manager.GetDeviceList())
            foreach (IVciDevice device in list)
                using (device)
                    if (number-- == 0)
                        return device.OpenBusAccessLayer();
        throw new Exception("there is no such board");
    }

    public static T Socket<T>(IBalObject board, byte port) where T : class
    {
        return (T)(object)board.OpenSocket(port, typeof(T));
    }

    public static void That(bool holds, string what)
    {
        if (!holds)
            throw new Exception("not so: " + what);
    }

    public static void Is<T>(T found, T expected, string what)
    {
        That(EqualityComparer<T>.Default.Equals(found, expected), what + " is " + found + ", not " + expected);
    }

    /// <summary>The exception of exactly this type that the action throws.</summary>
    public static T Throws<T>(Action action, string what) where T : Exception
    {
        try
        {
            action();
        }
        catch (T error)
        {
            That(error.GetType() == typeof(T), what + " throws " + error.GetType());
            return error;
        }
        throw new Exception(what + " throws nothing");
    }

    public static void Refused(uint code, Action action, string what)
    {
        Is(unchecked((uint)Throws<VciException>(action, what).HResult), code, what);
    }
}
